// LightSource "projection": agreement with pbrt-v4, and extensions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/scene/scene.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;

constexpr double kDegree = kPi / 180;

/// A .pfm file, red in the upper half of its rows and blue below.
std::string slide_pfm(int width, int height, float value = 1) {
  std::vector<float> rgb(std::size_t{3} * width * height, 0);
  for (int i = 0; i < width * height; ++i)
    rgb[3 * i + (i < width * ((height + 1) / 2) ? 0 : 2)] = value;
  return testing::pfm(width, height, rgb);
}

absl::StatusOr<SceneDescription> load_projection(const std::string& parameters,
                                                 const std::string& transform = "",
                                                 const std::string& bytes = slide_pfm(4, 2)) {
  const SceneFiles files;
  files.write("slide.pfm", bytes);
  files.write("scene.pbrt",
              "WorldBegin " + transform + "\nLightSource \"projection\" " + parameters);
  return files.load("scene.pbrt");
}

template <typename Params>
Params projection_light(const std::string& parameters, const std::string& transform = "") {
  auto scene = testing::value_of(load_projection(parameters, transform));
  return std::get<Params>(scene.lights.at(0).params);
}

const std::string kSlide = "\"string filename\" \"slide.pfm\" ";
const double kHalfPurple = (0.2126390058715104 + 0.0721923153607337) / 2;  // mean luminance

TEST(PbrtProjection, DefaultsArePbrt4s) {
  const auto p =
      projection_light<ProjectionLightParams>(kSlide + "\"float scale\" 3", "Translate 1 2 3");
  EXPECT_EQ(p.position_m, Vec3(1, 2, 3));
  EXPECT_EQ(p.intensity_cd, Rgb(3));
  EXPECT_EQ(p.image_name, "slide.pfm");
  EXPECT_EQ(p.picture->params().fov_rad, 90 * kDegree);
  EXPECT_EQ(p.picture->params().aspect, 2);
  EXPECT_EQ(p.picture->params().filter, ImageFilter::kNearest);
  // Its upper half has y > 0.
  const auto made = *ProjectionLight::create(p);
  EXPECT_EQ(made.intensity({1.9, 0.9, 1}), Rgb(3, 0, 0));
  EXPECT_EQ(made.intensity({1.9, -0.9, 1}), Rgb(0, 0, 3));
  EXPECT_EQ(made.intensity({2.1, 0.9, 1}), Rgb());
}

TEST(PbrtProjection, ScaleAlongTheLightsAxesChangesTheExtentOfThePicture) {
  // 3 times wider, 2 times higher and 2 times farther: half sides 2 * 3/2 and 1 * 2/2 at distance
  // 1.
  const auto p = projection_light<ProjectionLightParams>(kSlide, "Rotate 70 1 2 3 Scale 3 2 2");
  EXPECT_NEAR(p.picture->half().x, 3, 1e-12);
  EXPECT_NEAR(p.picture->half().y, 1, 1e-12);
  EXPECT_NEAR(p.picture->params().fov_rad, 90 * kDegree, 1e-12);
  EXPECT_NEAR(p.picture->params().aspect, 3, 1e-12);
  // Equal scale changes nothing; a mirror changes only the side.
  const auto q = projection_light<ProjectionLightParams>(kSlide, "Scale -5 5 5");
  EXPECT_EQ(q.picture->params().fov_rad, 90 * kDegree);
  EXPECT_EQ(q.axes.s, Vec3(-5, 0, 0));
  const auto beam = projection_light<BeamLightParams>(
      kSlide + "\"string projection\" \"orthographic\" \"float extent\" 0.5", "Scale 3 2 7");
  EXPECT_EQ(beam.width_m, 3);  // 0.5 times the aspect of 2, times 3
  EXPECT_EQ(beam.height_m, 1);
}

TEST(PbrtProjection, PowerEqualsThatOfPbrt4) {
  // At 90 degrees the picture covers [-2, 2] x [-1, 1] at distance 1.  Its texels have area 1 and
  // centres at x = +-1.5 and +-0.5, y = +-0.5.
  const double near = std::pow(1.5, -1.5), far = std::pow(3.5, -1.5);
  const double counted = kHalfPurple * 4 * (near + far);
  auto scene = testing::value_of(load_projection(kSlide + "\"float power\" 100 \"float scale\" 2"));
  const auto p = std::get<ProjectionLightParams>(scene.lights.at(0).params);
  EXPECT_NEAR(p.intensity_cd.g, 2 * 100 / counted, 1e-9);
  // The rectangle of half sides 2 and 1 covers 4 asin(2 / sqrt 5 / sqrt 2).
  const double lumens = p.intensity_cd.g * kHalfPurple * 4 * std::asin(2 / std::sqrt(10.0));
  EXPECT_THAT(remarks_of(scene), HasSubstr("from the same intensity as in pbrt-v4"));
  EXPECT_NEAR(luminance(ProjectionLight::create(p)->power({}).lumens), lumens, 1e-9);
  EXPECT_THAT(remarks_of(scene), HasSubstr(std::to_string(lumens).substr(0, 5)));
}

TEST(PbrtProjection, PowerIsExactForLightsThatPbrt4Lacks) {
  const auto bilinear = projection_light<ProjectionLightParams>(
      kSlide + "\"string filter\" \"bilinear\" \"float power\" 100");
  EXPECT_NEAR(luminance(ProjectionLight::create(bilinear)->power({}).lumens), 100, 1e-9);
  const auto even = projection_light<ProjectionLightParams>("\"float power\" 100 \"float fov\" 40");
  EXPECT_EQ(even.picture->params().image, nullptr);
  EXPECT_NEAR(luminance(ProjectionLight::create(even)->power({}).lumens), 100, 1e-9);
  const std::string beam = "\"string projection\" \"orthographic\" \"float power\" 100 ";
  const auto with_picture = projection_light<BeamLightParams>(kSlide + beam);
  EXPECT_EQ(with_picture.width_m, 2);
  EXPECT_EQ(with_picture.height_m, 1);
  EXPECT_NEAR(luminance(BeamLight::create(with_picture)->power({}).lumens), 100, 1e-9);
  EXPECT_NEAR(projection_light<BeamLightParams>(beam + "\"float extent\" 2").illuminance_lx.g, 25,
              1e-12);
}

TEST(PbrtProjection, ColourMultipliesThePicture) {
  const auto p =
      projection_light<ProjectionLightParams>(kSlide + "\"rgb I\" [1 2 3] \"float scale\" 2");
  EXPECT_EQ(p.intensity_cd, Rgb(2, 4, 6));
}

// The texels of the picture are RGB, so there is no spectrum to multiply.
TEST(PbrtProjection, ASpectrumBesideAPictureBecomesRgbWithARemark) {
  for (const std::string kind : {"", "\"string projection\" \"orthographic\" "}) {
    const auto scene = testing::value_of(load_projection(kind + kSlide + "\n\"blackbody I\" 2700"));
    EXPECT_EQ(scene.lights[0].spectrum, nullptr);
    EXPECT_THAT(
        remarks_of(scene),
        ::testing::MatchesRegex(
            "3:1 blackbody \"I\" of a light with a picture, whose colours are RGB -> the spectrum "
            "becomes RGB \\[1\\.[0-9]+ 0\\.[0-9]+ 0\\.[0-9]+\\] of luminance 1, also for "
            "queries by wavelength\n"));
    // Outside of the RGB gamut: no remark that wavelengths are exact.
    const auto red =
        testing::value_of(load_projection(kind + kSlide + "\"spectrum I\" [699 0 700 1 701 0]"));
    EXPECT_THAT(remarks_of(red), HasSubstr("2:"));
    EXPECT_THAT(remarks_of(red), HasSubstr("spectrum \"I\" of a light with a picture"));
    EXPECT_THAT(remarks_of(red), ::testing::Not(HasSubstr("exact")));
    EXPECT_EQ(remarks_of(*load_projection(kind + kSlide + "\"rgb I\" [1 .5 .2]")), "");
    const auto without = testing::value_of(load_projection(kind + "\"blackbody I\" 2700"));
    EXPECT_NE(without.lights[0].spectrum, nullptr);
    EXPECT_EQ(remarks_of(without), "");
  }
}

TEST(PbrtProjection, InvalidInputIsAnErrorWithItsPlace) {
  const auto error = [](const std::string& parameters, const std::string& transform = "") {
    return message(load_projection(parameters, transform).status());
  };
  EXPECT_THAT(error("\"float fov\" 180"),
              HasSubstr("scene.pbrt:2:26: \"float fov\" = 180 degrees, allowed (0, 180)"));
  EXPECT_THAT(error("\"float fov\" 0"), HasSubstr("\"float fov\" = 0"));
  EXPECT_THAT(error("\"string projection\" \"fisheye\""), HasSubstr("perspective, orthographic"));
  EXPECT_THAT(error("\"string projection\" \"orthographic\" \"float extent\" 0"),
              HasSubstr("\"float extent\" = 0 m, allowed: positive"));
  EXPECT_THAT(error("\"string projection\" \"orthographic\" \"float extent\" 1e20"),
              HasSubstr("beam.width and height"));
  EXPECT_THAT(error(kSlide + "\"string filter\" \"cubic\""), HasSubstr("nearest, bilinear"));
  EXPECT_THAT(error(kSlide + "\"float scale\" -1"), HasSubstr("\"float scale\" = -1"));
  EXPECT_THAT(error(kSlide + "\"float power\" -2"), HasSubstr("\"float power\" = -2"));
  EXPECT_THAT(error("\"string filename\" \"none.pfm\""), HasSubstr("none.pfm"));
  EXPECT_THAT(
      error(kSlide + "\"string projection\" \"orthographic\"", "Scale 1 2 1 Rotate 30 0 0 1"),
      HasSubstr("scene.pbrt:2:1: an orthographic projection under a transform that shears"));
  EXPECT_THAT(error("\"float fov\" 1e-150"),
              HasSubstr("scene.pbrt:2:26: \"float fov\" = 1e-150 degrees: projection.fov"));
  const auto with_bytes = [](const std::string& bytes, const std::string& parameters = "") {
    return message(load_projection(kSlide + parameters, "", bytes).status());
  };
  EXPECT_THAT(with_bytes(slide_pfm(2, 2, 0), "\"float power\" 5"),
              HasSubstr("for a light that illuminates nothing"));
  EXPECT_THAT(with_bytes(slide_pfm(2, 2, 1e30F), "\"float scale\" 1e30"),
              HasSubstr("scene.pbrt:2:56: projection.intensity of the brightest texel"));
}

TEST(PbrtProjection, TheScenesSphereHoldsABeamsRectangle) {
  auto description = testing::value_of(
      load_projection("\"string projection\" \"orthographic\" \"float extent\" 8"));
  const auto scene = testing::value_of(Scene::build(std::move(description)));
  EXPECT_NEAR(scene->sphere().radius_m, std::sqrt(32.0), 1e-9);
}

}  // namespace
}  // namespace lucerna

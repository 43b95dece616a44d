// LightSource "infinite" with a picture: agreement with pbrt-v4, and extensions.
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

/// A .pfm file with `value` in the upper half of its rows and 0 below.
std::string half_pfm(int width, int height, float value) {
  std::vector<float> rgb(std::size_t{3} * width * height, 0);
  std::fill_n(rgb.begin(), 3 * width * ((height + 1) / 2), value);
  return testing::pfm(width, height, rgb);
}

absl::StatusOr<SceneDescription> load_infinite(const std::string& parameters, int width, int height,
                                               float value = 2, const std::string& transform = "") {
  const SceneFiles files;
  files.write("sky.pfm", half_pfm(width, height, value));
  files.write("scene.pbrt", "WorldBegin " + transform +
                                "\nLightSource \"infinite\" \"string filename\" \"sky.pfm\" " +
                                parameters);
  return files.load("scene.pbrt");
}

ImageInfiniteLightParams infinite_light(const std::string& parameters, int width, int height,
                                        const std::string& transform = "") {
  auto scene = testing::value_of(load_infinite(parameters, width, height, 2, transform));
  return std::get<ImageInfiniteLightParams>(scene.lights.at(0).params);
}

TEST(PbrtImageLights, DefaultsArePbrt4s) {
  const auto p = infinite_light("\"float scale\" 3", 4, 4);
  EXPECT_EQ(p.map->mapping(), SphereMapping::kEqualArea);
  EXPECT_EQ(p.map->filter(), ImageFilter::kNearest);
  EXPECT_EQ(p.radiance_cd_m2, Rgb(3));
  EXPECT_EQ(p.image_name, "sky.pfm");
  // The upper half of the picture has the directions with y < 0.
  EXPECT_EQ(p.map->lookup({0.1, -0.99, 0.1}), Rgb(2));
  EXPECT_EQ(p.map->lookup({0.1, 0.99, 0.1}), Rgb(0));
}

TEST(PbrtImageLights, MappingAndFilterAreApplied) {
  const auto p = infinite_light("\"string mapping\" \"latlong\" \"string filter\" \"bilinear\"", 8,
                                4, "Rotate 90 1 0 0 Scale 2 2 2");
  EXPECT_EQ(p.map->mapping(), SphereMapping::kLatitudeLongitude);
  EXPECT_EQ(p.map->filter(), ImageFilter::kBilinear);
  const auto made = *ImageInfiniteLight::create(p);
  EXPECT_EQ(made.le_escaped({}, {0, 0, 1}), Rgb(2));  // rotated: +y became +z
  EXPECT_EQ(made.le_escaped({}, {0, 0, -1}), Rgb(0));
}

TEST(PbrtImageLights, IlluminanceComesFromAboveForLatitudeLongitude) {
  // The upper hemisphere has luminance 2, which gives 2 pi lx; 100 lx are wanted.
  const auto p = infinite_light("\"string mapping\" \"latlong\" \"float illuminance\" 100", 8, 4);
  EXPECT_NEAR(p.radiance_cd_m2.g, 100 / (2 * kPi), 1e-12);
}

TEST(PbrtImageLights, IlluminanceOfEqualAreaMapsEqualsThatOfPbrt4) {
  // A picture with 2 in its upper half covers half of +z's hemisphere (pi lx for luminance 1).
  // pbrt-v4's weights halve that, up to the sum over the centres of 64 x 64 texels.
  auto scene = testing::value_of(load_infinite("\"float illuminance\" 100", 64, 64));
  const auto p = std::get<ImageInfiniteLightParams>(scene.lights.at(0).params);
  EXPECT_NEAR(p.radiance_cd_m2.g * (2 * kPi / 4) / 100, 1, 1e-2);
  EXPECT_THAT(remarks_of(scene), HasSubstr("gets 200 lx"));
}

TEST(PbrtImageLights, InvalidInputIsAnErrorWithItsPlace) {
  const auto error = [](const std::string& parameters, int width, int height,
                        const std::string& transform = "") {
    return message(load_infinite(parameters, width, height, 2, transform).status());
  };
  EXPECT_THAT(error("", 4, 2), HasSubstr("scene.pbrt:2:24: \"string filename\": sky.pfm: an "
                                         "equal-area map of 4 x 2 texels, allowed: square"));
  EXPECT_THAT(error("\"string mapping\" \"cube\"", 4, 4), HasSubstr("equalarea, latlong"));
  EXPECT_THAT(error("\"string filter\" \"cubic\"", 4, 4), HasSubstr("nearest, bilinear"));
  EXPECT_THAT(error("\"float scale\" -1", 4, 4), HasSubstr("\"float scale\" = -1"));
  EXPECT_THAT(error("\"rgb L\" [1 1 1]", 4, 4), HasSubstr("\"L\" and \"filename\" are both given"));
  const std::string opening = "\"point3 portal\" [0 0 3  0 1 3  2 1 3  2 0 3]";
  EXPECT_EQ(error(opening, 4, 4, "Scale 1 2 1"), "");
  for (const char* kept : {"\"string filter\" \"nearest\"", "\"string mapping\" \"latlong\""})
    EXPECT_THAT(error(opening + kept, 4, 4, "Scale 1 2 1"),
                HasSubstr("picture behind a portal under a transform of unequal scale"));
  EXPECT_THAT(message(load_infinite("\"float illuminance\" 5", 4, 4, 0).status()),
              HasSubstr("is black above the horizon"));
}

TEST(PbrtImageLights, UnequalScaleMovesDirections) {
  const auto light = [](const std::string& transform) {
    auto scene = load_infinite("", 64, 64, 2, transform);
    EXPECT_TRUE(scene.ok()) << scene.status();
    return *ImageInfiniteLight::create(
        std::get<ImageInfiniteLightParams>(scene->lights.at(0).params));
  };
  const auto plain = light(""), stretched = light("Scale 1 2 3");
  double sum = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i)
    for (int k = 0; k < 2 * kSteps; ++k) {
      const double z = (2 * i + 1.0) / kSteps - 1, r = std::sqrt(1 - z * z);
      const double phi = (k + 0.5) * kPi / kSteps;
      const Vec3 w{r * std::cos(phi), r * std::sin(phi), z};
      EXPECT_EQ(stretched.le_escaped({}, w),
                plain.le_escaped({}, normalized(Vec3{w.x, w.y / 2, w.z / 3})));
      sum += stretched.pdf_li({}, w).per_sr;
    }
  // The density integrates to 1 over the directions of the world.
  EXPECT_NEAR(sum * 2 * kPi / kSteps / kSteps, 1, 1e-2);
}

const std::string kOblongPortal = "\"point3 portal\" [0 0 3  0 1 3  2 1 3  2 0 3] ";

PortalLightParams portal(const std::string& parameters, const std::string& transform = "") {
  auto scene = testing::value_of(load_infinite(kOblongPortal + parameters, 4, 4, 2, transform));
  return std::get<PortalLightParams>(scene.lights.at(0).params);
}

TEST(PbrtPortals, CornersAreInWorldSpaceAndThePictureIsRotated) {
  const auto p = portal("\"float scale\" 3", "Translate 5 6 7 Rotate 90 1 0 0");
  EXPECT_EQ(p.corners_m[2], (Vec3{2, 1, 3}));
  EXPECT_EQ(p.radiance_cd_m2, Rgb(3));
  EXPECT_EQ(p.image_name, "sky.pfm");
  // The bright half of the picture, y < 0, was rotated to z < 0.
  const auto upside = *PortalLight::create(p);
  EXPECT_LT(upside.le_escaped({1, 0.5F, 2.9F}, {0, 0, 1}).g, 1e-6F);
  const auto still = *PortalLight::create(portal("\"float scale\" 3"));
  EXPECT_EQ(still.le_escaped({1, 0.3F, 2.9F}, normalized(Vec3{0, -0.8F, 0.2F})).g, 0);
  EXPECT_EQ(still.le_escaped({1, 0.9F, 2.9F}, normalized(Vec3{0, -0.8F, 0.2F})).g, 6);
}

TEST(PbrtPortals, AnEqualAreaPictureIsResampledUnlessAFilterIsGiven) {
  EXPECT_TRUE(portal("").rectified);
  EXPECT_FALSE(portal("\"string filter\" \"nearest\"").rectified);
  EXPECT_EQ(portal("\"string filter\" \"nearest\"").map->filter(), ImageFilter::kNearest);
  EXPECT_FALSE(portal("\"string mapping\" \"latlong\"").rectified);
  EXPECT_EQ(portal("\"string mapping\" \"latlong\"").map->filter(), ImageFilter::kBilinear);
}

TEST(PbrtPortals, WithoutAPictureTheSkyIsUniform) {
  const auto of = [](const std::string& parameters) {
    auto scene = testing::value_of(testing::load_text(
        "WorldBegin Scale 1 2 3 LightSource \"infinite\" " + kOblongPortal + parameters));
    return std::pair{std::get<PortalLightParams>(scene.lights.at(0).params), remarks_of(scene)};
  };
  EXPECT_EQ(of("\"rgb L\" [1 2 3] \"float scale\" 2").first.radiance_cd_m2, Rgb(2, 4, 6));
  EXPECT_EQ(of("\"rgb L\" [1 2 3]").first.map, nullptr);
  EXPECT_EQ(of("\"rgb L\" [1 2 3]").second, "");
  // The portal of 2 m2 passes pi L A.
  const auto light = *PortalLight::create(of("\"rgb L\" [1 2 3]").first);
  EXPECT_NEAR(light.power({}).lumens.g, kPi * 2 * 2, 1e-9);
  // pbrt-v4: the cosine at the middle of its one texel is 1, times 2 pi.
  const auto [lit, remarks] = of("\"float illuminance\" 100");
  EXPECT_NEAR(lit.radiance_cd_m2.g, 100 / (2 * kPi), 1e-9);
  EXPECT_THAT(remarks, HasSubstr("half of it"));
}

TEST(PbrtPortals, BadPortalsAreErrorsWithTheirPlace) {
  const auto error = [](const std::string& portal) {
    return message(testing::load_text("WorldBegin\nLightSource \"infinite\" \"point3 portal\" " +
                                      portal + " \"rgb L\" [1 1 1]")
                       .status());
  };
  EXPECT_THAT(error("[0 0 3  0 1 3  2 1 3]"),
              HasSubstr("scene.pbrt:2:24: \"point3 portal\" of 3 points, allowed: 4"));
  const std::string not_flat = error("[0 0 3  0 1 3  2 1 4  2 0 3]");
  EXPECT_THAT(not_flat,
              HasSubstr("scene.pbrt:2:24: \"point3 portal\": infinite.portal = (0, 0, 3)"));
  EXPECT_THAT(not_flat, HasSubstr("(2, 1, 4)"));
  EXPECT_THAT(not_flat, HasSubstr("allowed: four corners of a rectangle in order"));
  EXPECT_THAT(error("[0 0 3  0 1 3  2.5 1 3  2 0 3]"), HasSubstr("rectangle"));  // a trapezium
  EXPECT_THAT(error("[0 0 3  0 1 3  3 2 3  3 1 3]"), HasSubstr("rectangle"));    // a parallelogram
  EXPECT_THAT(error("[0 0 3  0 1 3  0 1 3  0 0 3]"), HasSubstr("rectangle"));    // no area
  EXPECT_THAT(error("[0 0 1e39  0 1e39 1e39  1e39 1e39 1e39  1e39 0 1e39]"),
              HasSubstr("scene.pbrt:2:24: \"point3 portal\": infinite.portal = (0, 0, 1e+39) m"));
}

}  // namespace
}  // namespace lucerna

// LightSource "goniometric" with a picture: agreement with pbrt-v4, and extensions.
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

/// Rows from the top, one number per texel; `blue` multiplies the third channel.
std::string grey_pfm(int width, int height, const std::vector<float>& values, float blue = 1) {
  std::vector<float> rgb;
  for (const float v : values) rgb.insert(rgb.end(), {v, v, v * blue});
  return testing::pfm(width, height, rgb);
}

absl::StatusOr<SceneDescription> load_goniometric(const std::string& parameters,
                                                  const std::string& image,
                                                  const std::string& transform = "") {
  const SceneFiles files;
  files.write("lamp.pfm", image);
  files.write("scene.pbrt", "WorldBegin " + transform +
                                "\nLightSource \"goniometric\" \"string filename\" \"lamp.pfm\" " +
                                parameters);
  return files.load("scene.pbrt");
}

GoniometricLight goniometric_light(const std::string& parameters, const std::string& image,
                                   const std::string& transform = "") {
  auto scene = testing::value_of(load_goniometric(parameters, image, transform));
  EXPECT_EQ(remarks_of(scene), "");
  return *GoniometricLight::create(std::get<GoniometricLightParams>(scene.lights.at(0).params));
}

/// The four quarters of a square picture.
const std::string kQuarters = grey_pfm(2, 2, {1, 2, 3, 4});

// pbrt-v4 looks up the direction (x, z, y): the middle of the picture is light space's +y, its
// right is +x, its lower side +z.
TEST(PbrtGoniometric, ThePictureHasTheOrientationOfPbrt4) {
  const auto l = goniometric_light("", kQuarters);
  EXPECT_EQ(l.params().file, "lamp.pfm");
  EXPECT_EQ(l.params().map->sphere_map().mapping(), SphereMapping::kEqualArea);
  EXPECT_EQ(l.params().map->sphere_map().filter(), ImageFilter::kNearest);
  EXPECT_EQ(l.intensity({-0.5, 0.2, -0.5}), Rgb(1));
  EXPECT_EQ(l.intensity({0.5, -0.2, -0.5}), Rgb(2));
  EXPECT_EQ(l.intensity({-0.5, 0.2, 0.5}), Rgb(3));
  EXPECT_EQ(l.intensity({0.5, -0.2, 0.5}), Rgb(4));
  // Four texels around the middle, +y.
  const auto middle =
      goniometric_light("", grey_pfm(4, 4, {0, 0, 0, 0, 0, 5, 5, 0, 0, 5, 5, 0, 0, 0, 0, 0}));
  EXPECT_EQ(middle.intensity({0, 1, 0}), Rgb(5));
  EXPECT_EQ(middle.intensity({0, 0, 1}), Rgb(0));
  EXPECT_EQ(middle.intensity({0, -1, 0}), Rgb(0));
}

// pbrt-v2: +y at the top, longitude from +x by +z.
TEST(PbrtGoniometric, LatitudesAndLongitudesHaveTheOrientationOfPbrt2) {
  const auto l =
      goniometric_light("\"string mapping\" \"latlong\"", grey_pfm(4, 2, {1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(l.intensity({1, 0.1, 1}), Rgb(1));
  EXPECT_EQ(l.intensity({-1, 0.1, 1}), Rgb(2));
  EXPECT_EQ(l.intensity({-1, 0.1, -1}), Rgb(3));
  EXPECT_EQ(l.intensity({1, 0.1, -1}), Rgb(4));
  EXPECT_EQ(l.intensity({1, -0.1, 1}), Rgb(5));
  const auto smooth =
      goniometric_light("\"string mapping\" \"latlong\" \"string filter\" \"bilinear\"",
                        grey_pfm(4, 2, {1, 2, 3, 4, 5, 6, 7, 8}));
  // On the equator between the first two columns: the mean of 1, 2, 5 and 6.
  EXPECT_NEAR(smooth.intensity({0, 0, 1}).r, 3.5, 1e-12);
}

TEST(PbrtGoniometric, LevelsMultiplyAndPowerSetsTheTotal) {
  EXPECT_EQ(
      goniometric_light("\"rgb I\" [3 3 3] \"float scale\" 2", kQuarters).intensity({1, 1, 1}),
      Rgb(24));
  for (const char* mapping : {"equalarea", "latlong"}) {
    for (const char* filter : {"nearest", "bilinear"}) {
      const auto l = goniometric_light(std::string("\"float power\" 640 \"string mapping\" \"") +
                                           mapping + "\" \"string filter\" \"" + filter + "\"",
                                       kQuarters);
      EXPECT_NEAR(luminance(l.power({}).lumens), 640, 1e-9);
    }
  }
  // pbrt-v4 gives 640 lm to 4 pi times the mean of the texels, 2.5.
  EXPECT_NEAR(goniometric_light("\"float power\" 640", kQuarters).intensity({1, 1, 1}).r,
              4 * 640 / (4 * kPi * 2.5), 1e-9);
}

TEST(PbrtGoniometric, TransformsRotateMirrorAndStretch) {
  const auto turned = goniometric_light("", kQuarters, "Rotate 90 0 1 0 Scale 2 2 2");  // +z to +x
  EXPECT_EQ(turned.intensity({0.5, 0.2, 0.5}), Rgb(3));
  const auto mirrored = goniometric_light("", kQuarters, "Scale -1 1 1");
  EXPECT_EQ(mirrored.intensity({0.5, 0.2, 0.5}), Rgb(3));
  // The direction (1, 1, 1) of the light's own space is (1, 2, 1) in the world.
  const auto stretched = goniometric_light("", kQuarters, "Scale 1 2 1");
  const auto plain = goniometric_light("", kQuarters);
  for (const Vec3& own : {Vec3{1, 1, 1}, {-1, 0.5, 2}, {1, -1, 0.1}, {-2, -1, -3}})
    EXPECT_EQ(stretched.intensity(normalized(Vec3{own.x, 2 * own.y, own.z})),
              plain.intensity(normalized(own)));
}

TEST(PbrtGoniometric, ColoursBecomeTheirMeanWithARemark) {
  const auto scene = testing::value_of(load_goniometric("", grey_pfm(1, 1, {2}, 4)));
  EXPECT_EQ(remarks_of(scene),
            "2:27 lamp.pfm has colours, but a goniometric light has one intensity for each "
            "direction -> the mean "
            "of R, G and B, the same as in pbrt-v4\n");
  const auto& params = std::get<GoniometricLightParams>(scene.lights.at(0).params);
  EXPECT_EQ(params.map->at({0, 0, 1}), 4);  // (2 + 2 + 8) / 3
}

TEST(PbrtGoniometric, BadPicturesAreErrorsWithTheirPlace) {
  const auto error = [](const std::string& parameters, const std::string& image) {
    return message(load_goniometric(parameters, image).status());
  };
  EXPECT_THAT(error("", grey_pfm(4, 2, std::vector<float>(8, 1))),
              HasSubstr("scene.pbrt:2:27: \"string filename\": lamp.pfm: an equal-area map of 4 x "
                        "2 texels, allowed: square"));
  EXPECT_THAT(error("\"string mapping\" \"cube\"", kQuarters), HasSubstr("equalarea, latlong"));
  EXPECT_THAT(error("\"string filter\" \"cubic\"", kQuarters), HasSubstr("nearest, bilinear"));
  EXPECT_THAT(error("\"float power\" 5", grey_pfm(1, 1, {0})),
              HasSubstr("that illuminates nothing"));
  // Beyond the range of the scene's floats.
  EXPECT_THAT(
      error("\"rgb I\" [1e38 1e38 1e38]", grey_pfm(1, 1, {1e3F})),
      HasSubstr("scene.pbrt:2:56: the largest intensity of lamp.pfm times the light's level "
                "= (1e+41, 1e+41, 1e+41), allowed: each channel finite"));
}

TEST(PbrtGoniometric, ParametersOfPicturesDoNotApplyToPhotometricFiles) {
  const SceneFiles files;
  files.write("lamp.ies", "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n");
  files.write("scene.pbrt",
              "WorldBegin LightSource \"goniometric\" \"string filename\" \"lamp.ies\" "
              "\"string mapping\" \"latlong\"");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  EXPECT_THAT(remarks_of(scene), HasSubstr("mapping"));
}

}  // namespace
}  // namespace lucerna

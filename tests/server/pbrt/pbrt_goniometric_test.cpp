// LightSource "goniometric" with a picture: agreement with pbrt-v4, and extensions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/scene/scene.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::message;
using testing::remarks_of;
using testing::SceneFiles;

/// Rows from the top, one number per texel; `blue` multiplies the third channel.
std::string grey_pfm(int width, int height, const std::vector<float>& values, float blue = 1) {
  std::string bytes = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  for (int y = height; y-- > 0;)
    for (int x = 0; x < width; ++x)
      for (const float factor : {1.F, 1.F, blue}) {
        const float v = values[static_cast<std::size_t>(y * width + x)] * factor;
        bytes.append(reinterpret_cast<const char*>(&v), sizeof v);
      }
  return bytes;
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
  auto scene = load_goniometric(parameters, image, transform);
  if (!scene.ok()) throw std::runtime_error(message(scene.status()));
  EXPECT_EQ(remarks_of(*scene), "");
  return *GoniometricLight::create(std::get<GoniometricLightParams>(scene->lights.at(0).params));
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
  const auto scene = load_goniometric("", grey_pfm(1, 1, {2}, 4));
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(remarks_of(*scene),
            "2:27 lamp.pfm has colours, but a goniometric light has one intensity for each "
            "direction -> the mean "
            "of R, G and B, the same as in pbrt-v4\n");
  const auto& params = std::get<GoniometricLightParams>(scene->lights.at(0).params);
  EXPECT_EQ(params.map->at({0, 0, 1}), 4);  // (2 + 2 + 8) / 3
}

TEST(PbrtGoniometric, LightsOfOnePictureShareItAndTheSceneCountsItOnce) {
  const SceneFiles files;
  files.write("lamp.pfm", grey_pfm(2, 2, {1, 2, 3, 4}, 2));
  const std::string one = "LightSource \"goniometric\" \"string filename\" \"lamp.pfm\" ";
  files.write("scene.pbrt", "WorldBegin " + one + one + one + "\"string filter\" \"bilinear\"");
  auto description = files.load("scene.pbrt");
  ASSERT_TRUE(description.ok()) << description.status();
  const auto map = [&](std::size_t i) {
    return std::get<GoniometricLightParams>(description->lights.at(i).params).map;
  };
  EXPECT_EQ(map(0), map(1));
  EXPECT_NE(map(0), map(2));
  const std::uint64_t tables = map(0)->table_bytes() + map(2)->table_bytes();
  const std::uint64_t pictures = 2 * map(0)->sphere_map().image().bytes();
  const auto scene = Scene::build(*std::move(description));
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::uint64_t found = 0;
  for (const ScenePart& part : (*scene)->parts()) {
    if (part.name == "images") {
      EXPECT_EQ(part.bytes, pictures);
      ++found;
    } else if (part.name == "intensity maps") {
      EXPECT_EQ(part.bytes, tables);
      ++found;
    }
  }
  EXPECT_EQ(found, 2U);
}

// Row 32 of docs/extremes.md: unusual or invalid pictures.
TEST(PbrtGoniometric, BadPicturesAreErrorsWithTheirPlace) {
  const auto error = [](const std::string& parameters, const std::string& image) {
    return message(load_goniometric(parameters, image).status());
  };
  EXPECT_THAT(error("", grey_pfm(4, 2, std::vector<float>(8, 1))),
              HasSubstr("scene.pbrt:2:27: \"string filename\": lamp.pfm: an equal-area map of 4 x "
                        "2 texels, allowed: square"));
  for (const std::string& image : {grey_pfm(1, 1, {NAN}), grey_pfm(1, 1, {INFINITY}),
                                   grey_pfm(0, 0, {}), std::string("no picture")}) {
    const auto scene = load_goniometric("", image);
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_TRUE(scene->lights.empty());
    EXPECT_THAT(remarks_of(*scene), HasSubstr("2:27 \"string filename\": lamp.pfm: "));
    EXPECT_THAT(remarks_of(*scene), HasSubstr("-> the light is left out"));
  }
  EXPECT_THAT(error("\"string mapping\" \"cube\"", kQuarters), HasSubstr("equalarea, latlong"));
  EXPECT_THAT(error("\"string filter\" \"cubic\"", kQuarters), HasSubstr("nearest, bilinear"));
  EXPECT_THAT(error("\"float power\" 5", grey_pfm(1, 1, {0})),
              HasSubstr("that illuminates nothing"));
  // Beyond the range of the scene's floats.
  EXPECT_THAT(
      error("\"rgb I\" [1e38 1e38 1e38]", grey_pfm(1, 1, {1e3F})),
      HasSubstr("scene.pbrt:2:56: the largest intensity of lamp.pfm times the light's level "
                "= (1e+41, 1e+41, 1e+41), allowed: each channel finite"));
  // Valid but unusual: one texel, a row of 1e5, values below 0 (as 0, with a remark).
  EXPECT_EQ(goniometric_light("", grey_pfm(1, 1, {3})).intensity({0.3, -0.4, 0.5}), Rgb(3));
  const auto row = goniometric_light("\"string mapping\" \"latlong\"",
                                     grey_pfm(100000, 1, std::vector<float>(100000, 2)));
  EXPECT_NEAR(row.power({}).lumens.r, 8 * kPi, 1e-9);
  const auto negative = load_goniometric("", grey_pfm(2, 2, {-1, 2, 3, 4}));
  ASSERT_TRUE(negative.ok()) << negative.status();
  EXPECT_THAT(remarks_of(*negative), HasSubstr("1 texel with a value below 0 -> counted as 0"));
}

TEST(PbrtGoniometric, ParametersOfPicturesDoNotApplyToPhotometricFiles) {
  const SceneFiles files;
  files.write("lamp.ies", "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 100\n");
  files.write("scene.pbrt",
              "WorldBegin LightSource \"goniometric\" \"string filename\" \"lamp.ies\" "
              "\"string mapping\" \"latlong\"");
  const auto scene = files.load("scene.pbrt");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(remarks_of(*scene), HasSubstr("mapping"));
}

}  // namespace
}  // namespace lucerna

// Camera, film and hints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::load_text;
using testing::remarks_of;

SceneDescription description_of(const std::string& options) {
  const auto scene = load_text(options + " WorldBegin");
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : SceneDescription{};
}

TEST(PbrtCamera, DefaultsAreThoseOfPbrt) {
  const SceneDescription scene = description_of("");
  EXPECT_EQ(scene.film.width, 1280);
  EXPECT_EQ(scene.film.height, 720);
  EXPECT_EQ(scene.film.scale, 1);
  EXPECT_NEAR(scene.camera.screen_max.x, 16.0 / 9, 1e-12);  // tan 45 degrees on the shorter axis
  EXPECT_NEAR(scene.camera.screen_min.y, -1, 1e-12);
  EXPECT_EQ(scene.camera.world_from_camera, Transform());
  EXPECT_EQ(scene.hints.max_depth, 5);
  EXPECT_EQ(scene.hints.samples_per_pixel, 16);
  EXPECT_EQ(remarks_of(scene), "");
}

TEST(PbrtCamera, FieldOfViewSpansTheShorterSide) {
  const std::string camera = "Camera \"perspective\" \"float fov\" 60 ";
  const double t = std::sqrt(1.0 / 3);  // tan 30 degrees
  const auto wide = description_of(
      camera + "Film \"rgb\" \"integer xresolution\" 300 \"integer yresolution\" 100");
  EXPECT_NEAR(wide.camera.screen_max.x, 3 * t, 1e-12);
  EXPECT_NEAR(wide.camera.screen_max.y, t, 1e-12);
  const auto tall = description_of(
      camera + "Film \"rgb\" \"integer xresolution\" 100 \"integer yresolution\" 200");
  EXPECT_NEAR(tall.camera.screen_min.x, -t, 1e-12);
  EXPECT_NEAR(tall.camera.screen_min.y, -2 * t, 1e-12);
  const auto aspect =
      description_of("Camera \"perspective\" \"float fov\" 60 \"float frameaspectratio\" 2");
  EXPECT_NEAR(aspect.camera.screen_max.x, 2 * t, 1e-12);
  const auto window =
      description_of("Camera \"perspective\" \"float fov\" 60 \"float screenwindow\" [-1 3 -.5 2]");
  EXPECT_NEAR(window.camera.screen_max.x, 3 * t, 1e-12);
  EXPECT_NEAR(window.camera.screen_min.y, -.5 * t, 1e-12);
}

TEST(PbrtCamera, LooksAlongLookAt) {
  const auto scene =
      description_of("Scale -1 1 1 LookAt 0 -6 2  0 0 2  0 0 1 Camera \"perspective\"");
  const Transform& world_from_camera = scene.camera.world_from_camera;
  const auto eye = world_from_camera.point({0, 0, 0});
  EXPECT_NEAR(eye.y, -6, 1e-12);
  EXPECT_NEAR(eye.z, 2, 1e-12);
  EXPECT_NEAR(world_from_camera.vector({0, 0, 1}).y, 1, 1e-12);
  EXPECT_NEAR(world_from_camera.vector({0, 1, 0}).z, 1, 1e-12);
  // Left-handed: right is -x of the world, since Scale -1 1 1 mirrors.
  EXPECT_NEAR(world_from_camera.vector({1, 0, 0}).x, 1, 1e-12);
  EXPECT_NEAR(description_of("LookAt 0 -6 2  0 0 2  0 0 1 Camera \"perspective\"")
                  .camera.world_from_camera.vector({1, 0, 0})
                  .x,
              -1, 1e-12);
}

TEST(PbrtCamera, CoordinateSystemCameraIsWorldFromCamera) {
  const auto scene = load_text(
      "Translate 0 0 5 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\" Shape "
      "\"sphere\" "
      "CoordSysTransform \"world\" Shape \"sphere\" CoordSysTransform \"none\"");
  ASSERT_TRUE(scene.ok());
  const auto centre = [&](int i) {
    return std::get<SphereParams>(scene->shapes[i].geometry).world_from_object.point({0, 0, 0});
  };
  EXPECT_EQ(centre(0), Vec3<double>(0, 0, -5));
  EXPECT_EQ(centre(1), Vec3<double>(0, 0, 0));
  EXPECT_EQ(remarks_of(*scene),
            "1:132 coordinate system \"none\" is not defined -> the transform stays unchanged\n");
}

TEST(PbrtCamera, FilmScaleIsExposureTimesIsoOverAHundred) {
  EXPECT_NEAR(description_of(
                  "Film \"rgb\" \"float iso\" 50 Camera \"perspective\" \"float shutterclose\" .25")
                  .film.scale,
              0.125, 1e-15);
}

TEST(PbrtCamera, SettingsThatAreNotModelledGetRemarks) {
  const std::pair<const char*, const char*> kCases[] = {
      {"Camera \"orthographic\"",
       "1:1 Camera \"orthographic\" is not modelled -> a perspective camera, 90 degrees across the "
       "shorter side\n"},
      {"Camera \"perspective\" \"float lensradius\" 1",
       "1:1 \"lensradius\" is not modelled -> a pinhole\n"},
      {"Film \"rgb\" \"string sensor\" \"canon_eos_5d\"",
       "1:1 sensor \"canon_eos_5d\" is not modelled -> cie1931\n"},
      {"Film \"rgb\" \"float cropwindow\" [0 .5 0 1]",
       "1:1 \"cropwindow\" is not modelled -> the whole image\n"},
      {"Film \"rgb\" \"float cropwindow\" [0 1 0 1] \"integer pixelbounds\" [0 1280 0 720]", ""},
      {"Film \"gbuffer\"", "1:1 Film \"gbuffer\" is not modelled -> linear RGB\n"},
      {"PixelFilter \"gaussian\"",
       "1:1 PixelFilter \"gaussian\" is not modelled -> a box filter of one pixel\n"},
      {"PixelFilter \"box\" \"float xradius\" 1",
       "1:1 PixelFilter \"box\" is not modelled -> a box filter of one pixel\n"},
      {"ColorSpace \"rec2020\"",
       "1:1 ColorSpace \"rec2020\" is not modelled -> values are taken as srgb\n"},
      {"Integrator \"ambientocclusion\"",
       "1:1 Integrator \"ambientocclusion\" is not modelled -> path\n"},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_EQ(remarks_of(description_of(text)), expected) << text;
}

TEST(PbrtCamera, WrongSettingsAreErrors) {
  const std::pair<const char*, const char*> kCases[] = {
      {"Camera \"perspective\" \"float fov\" 180", "\"float fov\" = 180 degrees, allowed (0, 180)"},
      {"Camera \"perspective\" \"float screenwindow\" [1 2 3]",
       "expected four values x0 < x1, y0 < y1"},
      {"Camera \"perspective\" \"float shutterclose\" 0", "the shutter is open for 0 s"},
      {"Camera \"pinhole\"",
       "unknown Camera \"pinhole\", expected one of perspective orthographic"},
      {"Film \"rgb\" \"integer xresolution\" 0",
       "Film of 0 by 720 pixels, allowed 1 to 65536 each way"},
      {"Film \"rgb\" \"integer xresolution\" 100000", "Film of 100000 by 720 pixels"},
      {"Integrator \"path\" \"integer maxdepth\" -1", "\"integer maxdepth\" = -1"},
      {"Sampler \"zsobol\" \"integer pixelsamples\" 0",
       "0 samples for each pixel, allowed: 1 or more"},
      {"ColorSpace \"cmyk\"", "unknown colour space \"cmyk\", expected one of srgb"},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_THAT(error_of(std::string(text) + " WorldBegin"), HasSubstr(expected)) << text;
}

}  // namespace
}  // namespace lucerna

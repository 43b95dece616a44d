// Camera, film and hints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
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
  return scene.ok() ? *scene : SceneDescription();
}

TEST(PbrtCamera, DefaultsAreThoseOfPbrt) {
  const SceneDescription scene = description_of("");
  EXPECT_EQ(scene.film.width, 1280);
  EXPECT_EQ(scene.film.height, 720);
  EXPECT_EQ(scene.film.scale, 1);
  EXPECT_NEAR(scene.camera.screen_max.x, 16.0 / 9, 1e-12);  // tan 45 degrees on the shorter axis
  EXPECT_NEAR(scene.camera.screen_min.y, -1, 1e-12);
  EXPECT_EQ(scene.camera.world_from_camera, Transform());
  EXPECT_EQ(scene.camera.projection, Projection::kPerspective);
  EXPECT_EQ(scene.camera.lens_radius, 0);
  EXPECT_FALSE(scene.film.crop.has_value());
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
  const auto scene = testing::value_of(load_text(
      "Translate 0 0 5 Camera \"perspective\" WorldBegin CoordSysTransform \"camera\" Shape "
      "\"sphere\" "
      "CoordSysTransform \"world\" Shape \"sphere\" CoordSysTransform \"none\""));
  const auto centre = [&](int i) {
    return std::get<SphereParams>(scene.shapes[i].geometry).world_from_object.point({0, 0, 0});
  };
  EXPECT_EQ(centre(0), Vec3(0, 0, -5));
  EXPECT_EQ(centre(1), Vec3(0, 0, 0));
  EXPECT_EQ(remarks_of(scene),
            "1:132 coordinate system \"none\" is not defined -> the transform stays unchanged\n");
}

TEST(PbrtCamera, FilmScaleIsExposureTimesIsoOverAHundred) {
  EXPECT_NEAR(description_of(
                  "Film \"rgb\" \"float iso\" 50 Camera \"perspective\" \"float shutterclose\" .25")
                  .film.scale,
              0.125, 1e-15);
}

TEST(PbrtCamera, OrthographicScreenIsInMetres) {
  const auto scene = description_of(
      "Camera \"orthographic\" Film \"rgb\" \"integer xresolution\" 300 \"integer yresolution\" "
      "100");
  EXPECT_EQ(scene.camera.projection, Projection::kOrthographic);
  EXPECT_NEAR(scene.camera.screen_min.x, -3, 1e-12);
  EXPECT_NEAR(scene.camera.screen_max.y, 1, 1e-12);
  const auto window =
      description_of("Camera \"orthographic\" \"float screenwindow\" [-2 3 -.5 1]").camera;
  EXPECT_EQ(window.screen_min, (Vec2{-2, -.5}));
  EXPECT_EQ(window.screen_max, (Vec2{3, 1}));
}

TEST(PbrtCamera, LensesAndMappingsAreRead) {
  const auto lens =
      description_of("Camera \"orthographic\" \"float lensradius\" .5 \"float focaldistance\" 7");
  EXPECT_EQ(lens.camera.lens_radius, .5);
  EXPECT_EQ(lens.camera.focal_distance, 7);
  EXPECT_EQ(description_of("Camera \"perspective\" \"float lensradius\" .5").camera.focal_distance,
            1e6);
  EXPECT_EQ(description_of("Camera \"spherical\"").camera.projection, Projection::kEqualArea);
  EXPECT_EQ(description_of("Camera \"spherical\" \"string mapping\" \"equirectangular\"")
                .camera.projection,
            Projection::kEquirectangular);
}

// pbrt-v4 rounds both ends up, in floats: 0.55 of 100 pixels is 55 there, but 55.00000000000001 in
// doubles.
TEST(PbrtCamera, CropsHavePixelsOfTheFilm) {
  const auto crop = [](const std::string& parameters) {
    const auto film = description_of(
                          "Film \"rgb\" \"integer xresolution\" 100 \"integer "
                          "yresolution\" 10 " +
                          parameters)
                          .film;
    EXPECT_EQ(film.width, 100);
    const FilmCrop c = film.crop.value_or(FilmCrop{});
    return std::array{c.x0, c.x1, c.y0, c.y1};
  };
  EXPECT_EQ(crop("\"float cropwindow\" [.55 1 .21 .4]"), (std::array{55, 100, 3, 4}));
  EXPECT_EQ(crop("\"float cropwindow\" [1 .55 .4 .21]"), (std::array{55, 100, 3, 4}));
  EXPECT_EQ(crop("\"integer pixelbounds\" [10 20 0 10]"), (std::array{10, 20, 0, 10}));
  EXPECT_EQ(crop("\"integer pixelbounds\" [0 100 0 10]"), (std::array{0, 0, 0, 0}));
  EXPECT_EQ(crop("\"integer pixelbounds\" [1 2 3 4] \"float cropwindow\" [0 .5 0 1]"),
            (std::array{0, 50, 0, 10}));
}

// The largest distance from the centre, in pixels.
TEST(PbrtCamera, FiltersHaveTheRadiiOfPbrt) {
  const auto radius = [](const std::string& filter) {
    const auto film = description_of(filter).film;
    return film.filter == nullptr ? 0 : film.filter->sample({1, 1}).position_px.x - 0.5;
  };
  EXPECT_NEAR(radius(""), 1.5, 1e-6);  // Gaussian
  EXPECT_NEAR(radius("PixelFilter \"gaussian\""), 1.5, 1e-6);
  EXPECT_NEAR(radius("PixelFilter \"triangle\""), 2, 1e-6);
  EXPECT_NEAR(radius("PixelFilter \"mitchell\""), 2, 1e-6);
  EXPECT_NEAR(radius("PixelFilter \"sinc\""), 4, 1e-6);
  EXPECT_NEAR(radius("PixelFilter \"sinc\" \"float xradius\" 3"), 3, 1e-6);
  EXPECT_EQ(radius("PixelFilter \"box\""), 0);
  EXPECT_NEAR(radius("PixelFilter \"box\" \"float xradius\" 2"), 2, 1e-6);
  EXPECT_FALSE(description_of("").film.filter->has_negative_weights());
  EXPECT_TRUE(description_of("PixelFilter \"sinc\"").film.filter->has_negative_weights());
}

TEST(PbrtCamera, SettingsThatAreNotModelledGetRemarks) {
  const std::pair<const char*, const char*> kCases[] = {
      {"Camera \"realistic\" \"float focusdistance\" 2",
       "1:1 Camera \"realistic\" is not modelled -> a perspective camera, 90 degrees across the "
       "shorter side\n"},
      {"Camera \"orthographic\" \"float fov\" 40",
       "1:23 parameter \"fov\" of Camera \"orthographic\" is not known -> it changes nothing\n"},
      {"Camera \"spherical\" \"float lensradius\" 1", ""},
      {"PixelFilter \"box\" \"float sigma\" 1",
       "1:19 parameter \"sigma\" of PixelFilter \"box\" is not known -> it changes nothing\n"},
      {"Film \"rgb\" \"string sensor\" \"canon_eos_5d\"",
       "1:1 sensor \"canon_eos_5d\" is not modelled -> cie1931\n"},
      {"Film \"rgb\" \"float cropwindow\" [0 1 0 1] \"integer pixelbounds\" [0 1280 0 720]",
       "1:41 \"pixelbounds\" beside \"cropwindow\" -> \"cropwindow\" counts\n"},
      {"Film \"gbuffer\"", "1:1 Film \"gbuffer\" is not modelled -> linear RGB\n"},
      {"ColorSpace \"rec2020\"", ""},
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
      {"\nCamera \"perspective\" \"float fov\" 0", "scene.pbrt:2:22: \"float fov\" = 0 degrees"},
      {"Camera \"orthographic\" \"float screenwindow\" [1 -1 0 1]",
       "expected four values x0 < x1, y0 < y1"},
      {"Camera \"orthographic\" \"float screenwindow\" [0 1e300 0 1]", "in [-1e+09, 1e+09]"},
      {"Camera \"perspective\" \"float frameaspectratio\" 0",
       "\"float frameaspectratio\" = 0, allowed [1e-06, 1e+06]"},
      {"\nCamera \"perspective\" \"float lensradius\" -1",
       "scene.pbrt:2:22: \"float lensradius\" = -1, allowed [0, 1e+06]"},
      {"Camera \"orthographic\" \"float lensradius\" nan", "nan"},
      {"Camera \"orthographic\" \"float focaldistance\" 0",
       "\"float focaldistance\" = 0, allowed [1e-06, 1e+30]"},
      {"Camera \"spherical\" \"string mapping\" \"cube\"",
       "unknown mapping \"cube\", expected one of equalarea equirectangular"},
      {"\nFilm \"rgb\" \"float cropwindow\" [0.5 0.5 0 1]",
       "scene.pbrt:2:12: \"cropwindow\" [0.5 0.5 0 1] holds no pixel of a film of 1280 by 720"},
      {"Film \"rgb\" \"float cropwindow\" [0 1.5 0 1]", "allowed: four values in [0, 1]"},
      {"Film \"rgb\" \"float cropwindow\" [0 1 0]",
       "\"cropwindow\" has 3 values, expected four: x0 x1 y0 y1"},
      {"Film \"rgb\" \"integer pixelbounds\" [0 2000 0 10]",
       "\"pixelbounds\" [0 2000 0 10], allowed: not empty and within [0 1280 0 720]"},
      {"Film \"rgb\" \"integer pixelbounds\" [5 5 0 10]", "allowed: not empty"},
      {"Film \"rgb\" \"float cropwindow\" [0 1e300 0 1]", "allowed: four values in [0, 1]"},
      {"Film \"rgb\" \"integer pixelbounds\" [-5 5 0 10]", "\"pixelbounds\" [-5 5 0 10]"},
      {"\nPixelFilter \"gaussian\" \"float xradius\" 0",
       "scene.pbrt:2:1: PixelFilter \"gaussian\": xradius = 0 pixels, allowed [0.001, 64]"},
      {"PixelFilter \"box\" \"float yradius\" 1e9", "yradius = 1000000000 pixels"},
      {"PixelFilter \"gaussian\" \"float sigma\" -1", "sigma = -1 pixels"},
      {"PixelFilter \"sinc\" \"float tau\" 0", "tau = 0 pixels"},
      {"PixelFilter \"mitchell\" \"float B\" 50", "B = 50, C = 0.333"},
      {"PixelFilter \"lanczos\"",
       "unknown PixelFilter \"lanczos\", expected one of box gaussian mitchell sinc triangle"},
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

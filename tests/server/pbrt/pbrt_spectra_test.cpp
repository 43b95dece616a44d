// Spectra of lights like in pbrt-v4.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::light_of;
using testing::load_world;
using testing::message;
using testing::SceneFiles;
using testing::world_error_of;
using testing::world_remarks_of;

std::shared_ptr<const Spectrum> spectrum_of(const std::string& text) {
  return load_world(text)->lights.at(0).spectrum;
}

TEST(PbrtSpectra, BelongToTheirLights) {
  const auto body = spectrum_of("LightSource \"point\" \"blackbody I\" 2700");
  ASSERT_TRUE(body);
  EXPECT_EQ(std::get<BlackBody>(body->source()).kelvin, 2700);
  for (const char* name : {"A", "D50", "D65", "F1", "F2", "F11", "F12"}) {
    const auto s = spectrum_of(std::string("LightSource \"distant\" \"spectrum L\" \"stdillum-") +
                               name + "\"");
    ASSERT_TRUE(s);
    EXPECT_EQ(std::get<CieIlluminant>(s->source()).name, name);
  }
  const auto samples = spectrum_of("LightSource \"infinite\" \"spectrum L\" [400 1 500 2 700 0.5]");
  ASSERT_TRUE(samples);
  EXPECT_THAT(std::get<SampledSpectrum>(samples->source()).values, ElementsAre(1, 2, 0.5));
  EXPECT_FALSE(spectrum_of("LightSource \"point\" \"rgb I\" [1 2 3]"));
  EXPECT_FALSE(spectrum_of("LightSource \"point\""));
  const auto scene = load_world(
      "AreaLightSource \"diffuse\" \"blackbody L\" 4000 Shape \"disk\" Shape \"sphere\"");
  ASSERT_TRUE(scene->shapes[0].emission->spectrum);
  EXPECT_EQ(scene->shapes[0].emission->spectrum, scene->shapes[1].emission->spectrum);
}

TEST(PbrtSpectra, ComeFromFiles) {
  const SceneFiles files;
  files.write("scene.pbrt", "WorldBegin LightSource \"point\" \"spectrum I\" \"lamp.spd\"");
  files.write("lamp.spd", "# a lamp\r\n400 1 # violet\n500 +2.5\n\n700\t5e-1");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  const auto& s = std::get<SampledSpectrum>(scene.lights[0].spectrum->source());
  EXPECT_THAT(s.wavelengths_nm, ElementsAre(400, 500, 700));
  EXPECT_THAT(s.values, ElementsAre(1, 2.5, 0.5));
  EXPECT_EQ(scene.assets.back().name, "lamp.spd");
  files.write("lamp.spd", "400 1\n500 two");
  EXPECT_THAT(message(files.load("scene.pbrt").status()),
              HasSubstr("lamp.spd:2: \"two\", expected a finite number"));
  files.write("lamp.spd", "400 1 500");
  EXPECT_THAT(message(files.load("scene.pbrt").status()), HasSubstr("expected pairs"));
  files.write("lamp.spd", "# nothing");
  EXPECT_THAT(message(files.load("scene.pbrt").status()), HasSubstr("holds no numbers"));
}

TEST(PbrtSpectra, InvalidSpectraAreErrorsOrGetRemarks) {
  EXPECT_THAT(world_error_of("LightSource \"point\" \"spectrum I\" \"stdillum-F13\""),
              HasSubstr("scene.pbrt:1:32: spectrum \"I\": unknown illuminant \"F13\", allowed: A"));
  EXPECT_THAT(world_error_of("LightSource \"point\" \"spectrum I\" \"gone.spd\""),
              HasSubstr("gone.spd"));
  EXPECT_THAT(world_error_of("LightSource \"point\" \"spectrum I\" [500 1 400 1]"),
              HasSubstr("400 nm follows 500"));
  EXPECT_THAT(world_error_of("LightSource \"point\" \"spectrum I\" [500 1 600 -1]"),
              HasSubstr("value -1"));
  EXPECT_THAT(world_error_of("LightSource \"point\" \"blackbody I\" 20"),
              HasSubstr("black body of 20 K, allowed: [100, 1e7] K"));
  const std::string infrared = "LightSource \"point\" \"spectrum I\" [900 1 1000 1]";
  EXPECT_THAT(world_remarks_of(infrared), HasSubstr("has no visible light -> black"));
  EXPECT_TRUE(light_of<PointLightParams>(infrared).intensity_cd.is_black());
}

}  // namespace
}  // namespace lucerna

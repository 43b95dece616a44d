// Levels, positions and directions of lights like in pbrt-v4.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::light_of;
using testing::load_world;
using testing::remarks_of;
using ::testing::StartsWith;
using testing::world_error_of;
using testing::world_remarks_of;

ShapeDescription::Emission emission(const std::string& text) {
  const auto scene = load_world(text);
  if (!scene.ok() || !scene->shapes.at(0).emission) {
    ADD_FAILURE() << text << ": " << scene.status();
    return {};
  }
  return *scene->shapes[0].emission;
}

TEST(PbrtLights, RgbIsTheLevelAndScaleMultipliesIt) {
  EXPECT_EQ(light_of<PointLightParams>("LightSource \"point\" \"rgb I\" [10 20 30]").intensity_cd,
            Rgb(10, 20, 30));
  EXPECT_EQ(light_of<PointLightParams>("LightSource \"point\" \"float scale\" 3").intensity_cd,
            Rgb(3));
  EXPECT_EQ(
      light_of<DistantLightParams>("LightSource \"distant\" \"rgb L\" [2 2 2]").illuminance_lx,
      Rgb(2));
  EXPECT_EQ(light_of<UniformInfiniteLightParams>("LightSource \"infinite\" \"rgb L\" [1 2 3] "
                                                 "\"float scale\" 2")
                .radiance_cd_m2,
            Rgb(2, 4, 6));
  EXPECT_EQ(
      emission("AreaLightSource \"diffuse\" \"rgb L\" [5 6 7] Shape \"sphere\"").radiance_cd_m2,
      Rgb(5, 6, 7));
}

TEST(PbrtLights, PowerOfAPointIsSpreadOverTheSphere) {
  // 150 lm / 4 pi sr
  EXPECT_NEAR(
      light_of<PointLightParams>("LightSource \"point\" \"rgb I\" [1 1 1] \"float power\" 150")
          .intensity_cd.g,
      11.936620731892151, 1e-12);
}

TEST(PbrtLights, PowerMultipliesRgbAndScaleAndARemarkGivesTheResult) {
  const std::string text =
      "LightSource \"point\" \"rgb I\" [4 4 4] \"float scale\" .5 \"float power\" 100";
  EXPECT_NEAR(light_of<PointLightParams>(text).intensity_cd.g, 2 * 100 / (4 * kPi), 1e-12);
  EXPECT_EQ(world_remarks_of(text),
            "1:65 \"power\" 100 lm multiplies a level of luminance 2 -> 200 lm, the same as in "
            "pbrt-v4\n");
  EXPECT_EQ(world_remarks_of("LightSource \"point\" \"float power\" 100"), "");
}

TEST(PbrtLights, PowerOfASpotFollowsItsCone) {
  // coneangle 60, no smooth edge: 2 pi (1 - cos 60) = pi sr.
  const auto hard = light_of<SpotLightParams>(
      "LightSource \"spot\" \"float power\" 10 \"float coneangle\" 60 \"float conedeltaangle\" 0");
  EXPECT_NEAR(hard.intensity_cd.r, 10 / kPi, 1e-12);
  EXPECT_EQ(hard.falloff_start_rad, hard.cone_half_angle_rad);
  // A smooth edge over the whole cone halves it, the mean of smoothstep.
  const auto soft = light_of<SpotLightParams>(
      "LightSource \"spot\" \"float power\" 10 \"float coneangle\" 60 \"float conedeltaangle\" 60");
  EXPECT_NEAR(soft.intensity_cd.r, 20 / kPi, 1e-12);
}

TEST(PbrtLights, ASpotMayHaveOtherProfiles) {
  const std::string spot = "LightSource \"spot\" \"float coneangle\" 60 \"float conedeltaangle\" ";
  const auto quartic =
      light_of<SpotLightParams>(spot + "60 \"string profile\" \"quartic\" \"float power\" 10");
  EXPECT_EQ(quartic.profile, SpotProfile::kQuartic);
  // The mean of x^4 is 1/5 of the cone's pi sr.
  EXPECT_NEAR(quartic.intensity_cd.r, 50 / kPi, 1e-12);
  EXPECT_EQ(light_of<SpotLightParams>(spot + "5 \"string profile\" \"smoothstep\"").profile,
            SpotProfile::kSmoothstep);
  EXPECT_EQ(light_of<SpotLightParams>(spot + "5").profile, SpotProfile::kSmoothstep);
  EXPECT_EQ(light_of<SpotLightParams>(spot + "60 \"string profile\" \"quadratic\"").profile,
            SpotProfile::kQuadratic);
  EXPECT_THAT(world_error_of(spot + "5 \"string profile\" \"cubic\""),
              HasSubstr("\"string profile\" = \"cubic\", allowed: smoothstep, quadratic, quartic"));
}

TEST(PbrtLights, SpotDefaultsAndPlacement) {
  const auto spot = light_of<SpotLightParams>(
      "Translate 1 0 0 Scale 2 2 2 LightSource \"spot\" \"point3 from\" [0 0 1] \"point3 to\" [0 3 "
      "1]");
  EXPECT_EQ(spot.position_m, Vec3(1, 0, 2));
  EXPECT_EQ(normalized(spot.axis), Vec3(0, 1, 0));
  EXPECT_NEAR(spot.cone_half_angle_rad, kPi / 6, 1e-15);
  EXPECT_NEAR(spot.falloff_start_rad, kPi * 25 / 180, 1e-15);
  EXPECT_EQ(normalized(light_of<SpotLightParams>("LightSource \"spot\"").axis), Vec3(0, 0, 1));
}

TEST(PbrtLights, ADistantLightWithAnAngularDiameterIsASun) {
  const auto sun = light_of<SunLightParams>(
      "LightSource \"distant\" \"point3 from\" [0 0 5] \"point3 to\" [0 0 1] \"rgb L\" [1 2 3] "
      "\"float angulardiameter\" 0.5");
  EXPECT_NEAR(sun.angular_diameter_rad, kPi / 360, 1e-17);
  EXPECT_EQ(normalized(sun.to_light), Vec3(0, 0, 1));
  EXPECT_EQ(sun.illuminance_lx, Rgb(1, 2, 3));
  EXPECT_THAT(world_error_of("LightSource \"distant\" \"float angulardiameter\" 0"),
              HasSubstr("\"float angulardiameter\" = 0 degrees, allowed (0, 180]"));
  EXPECT_THAT(world_error_of("LightSource \"distant\" \"float angulardiameter\" 181"),
              HasSubstr("= 181 degrees"));
  EXPECT_THAT(world_error_of("Scale 1 1 2 LightSource \"distant\" \"float angulardiameter\" 1"),
              HasSubstr("angulardiameter\" under a transform of unequal scale"));
}

TEST(PbrtLights, DistantLightShinesFromTheFirstPointToTheSecond) {
  const auto distant = light_of<DistantLightParams>(
      "Rotate 90 1 0 0 LightSource \"distant\" \"point3 from\" [0 0 5] \"point3 to\" [0 0 2] "
      "\"float illuminance\" 1000");
  const auto to_light = normalized(distant.to_light);
  EXPECT_NEAR(to_light.y, -1, 1e-15);
  EXPECT_EQ(distant.illuminance_lx, Rgb(1000));
  EXPECT_EQ(normalized(light_of<DistantLightParams>("LightSource \"distant\"").to_light),
            Vec3(0, 0, -1));
}

TEST(PbrtLights, IlluminanceOfAnInfiniteLightIsPiTimesItsRadiance) {
  EXPECT_NEAR(
      light_of<UniformInfiniteLightParams>("LightSource \"infinite\" \"float illuminance\" 100")
          .radiance_cd_m2.r,
      100 / kPi, 1e-12);
}

TEST(PbrtLights, PowerOfAShapeIsSpreadOverItsAreaAndSides) {
  const std::string light = "AreaLightSource \"diffuse\" \"float power\" 100 ";
  const std::string both = light + "\"bool twosided\" true ";
  // Disk of radius 2: area 4 pi, under Scale 3 1 1: 12 pi.
  EXPECT_NEAR(emission(light + "Shape \"disk\" \"float radius\" 2").radiance_cd_m2.r,
              100 / (4 * kPi * kPi), 1e-12);
  EXPECT_NEAR(emission(both + "Scale 3 1 1 Shape \"disk\" \"float radius\" 2").radiance_cd_m2.r,
              100 / (2 * 12 * kPi * kPi), 1e-12);
  EXPECT_NEAR(emission(light + "Scale 2 2 2 Shape \"sphere\"").radiance_cd_m2.r,
              100 / (16 * kPi * kPi), 1e-12);
  const std::string patch =
      "Scale 2 1 1 Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 3 0 1 3 0]";
  EXPECT_NEAR(emission(light + patch).radiance_cd_m2.r, 100 / (6 * kPi), 1e-12);
}

TEST(PbrtLights, PowerOfAMeshIsThatOfTheWholeMeshWithARemark) {
  // A square of 2 by 2 and half of it again: areas 2, 2 and 2.
  const std::string text =
      "AreaLightSource \"diffuse\" \"float power\" 12\nShape \"trianglemesh\" "
      "\"point3 P\" [0 0 0 2 0 0 2 2 0 0 2 0 4 0 0] \"integer indices\" [0 1 2 0 2 3 1 4 2]";
  EXPECT_NEAR(emission(text).radiance_cd_m2.r, 12 / (6 * kPi), 1e-12);
  EXPECT_EQ(world_remarks_of(text),
            "1:38 \"power\" on a mesh of 3 primitives; pbrt-v4 gives this power to each of them -> "
            "the power of the whole mesh\n");
}

TEST(PbrtLights, BlackBodiesHaveLuminanceOneBeforeScale) {
  const auto point =
      light_of<PointLightParams>("LightSource \"point\" \"blackbody I\" 2700 \"float scale\" 12");
  EXPECT_NEAR(luminance(point.intensity_cd), 12, 1e-9);
  EXPECT_GT(point.intensity_cd.r, 2 * point.intensity_cd.g);
  const auto power =
      light_of<PointLightParams>("LightSource \"point\" \"blackbody I\" 2700 \"float power\" 100");
  EXPECT_NEAR(luminance(power.intensity_cd), 100 / (4 * kPi), 1e-9);
  EXPECT_EQ(world_remarks_of("LightSource \"point\" \"blackbody I\" 2700 \"float power\" 100"), "");
  EXPECT_THAT(world_remarks_of("LightSource \"point\" \"blackbody I\" 1000"),
              StartsWith("1:32 blackbody \"I\" is outside of the RGB gamut -> linear RGB ["));
  EXPECT_THAT(world_remarks_of("LightSource \"point\" \"spectrum I\" \"metal-Au-k\""),
              HasSubstr("is not the spectrum of a light -> linear RGB [1 1 1]"));
}

TEST(PbrtLights, ObjectsNeverEmit) {
  const auto scene = testing::value_of(load_world(
      "ObjectBegin \"o\" AreaLightSource \"diffuse\"\nShape \"disk\" ObjectEnd Shape \"disk\""));
  EXPECT_FALSE(scene.objects[0].shapes[0].emission);
  EXPECT_FALSE(scene.shapes[0].emission);  // ObjectEnd restores the state of ObjectBegin
  EXPECT_EQ(remarks_of(scene),
            "2:1 an area light within an object definition -> the shape emits nothing\n");
}

TEST(PbrtLights, LightFeaturesThatAreNotModelledGetRemarks) {
  const std::pair<const char*, const char*> kCases[] = {
      {"LightSource \"point\" \"float power\" 0",
       "1:32 \"power\" 0 is taken as not given -> the level of \"I\"\n"},
  };
  for (const auto& [text, expected] : kCases) EXPECT_EQ(world_remarks_of(text), expected) << text;
}

TEST(PbrtLights, ParametersOfPicturesAreCheckedWithoutAPicture) {
  const std::pair<const char*, const char*> kBad[] = {
      {"LightSource \"infinite\" \"string mapping\" \"cubemap\"",
       "scene.pbrt:1:35: \"string mapping\" = \"cubemap\", allowed: equalarea, latlong"},
      {"LightSource \"projection\" \"string filter\" \"trilinear\"",
       "scene.pbrt:1:37: \"string filter\" = \"trilinear\", allowed: nearest, bilinear"},
      {"LightSource \"goniometric\" \"string mapping\" \"cubemap\"", "allowed: equalarea, latlong"},
      {"LightSource \"infinite\" \"point3 portal\" [0 0 1 1 0 1 1 1 1 0 1 1] "
       "\"string filter\" \"cubic\"",
       "allowed: nearest, bilinear"},
      {"AreaLightSource \"diffuse\" \"string filter\" \"cubic\" Shape \"disk\"",
       "allowed: nearest, bilinear"},
  };
  for (const auto& [text, expected] : kBad)
    EXPECT_THAT(world_error_of(text), HasSubstr(expected)) << text;
  for (const std::string light :
       {"LightSource \"infinite\"", "LightSource \"goniometric\"",
        "LightSource \"infinite\" \"point3 portal\" [0 0 1 1 0 1 1 1 1 0 1 1]"}) {
    const auto scene = testing::value_of(load_world("\n" + light +
                                                    "\n\"string mapping\" \"latlong\"\n"
                                                    "\"string filter\" \"bilinear\""));
    EXPECT_EQ(
        remarks_of(scene),
        "3:1 \"string mapping\" without a picture (\"string filename\") -> it changes nothing\n"
        "4:1 \"string filter\" without a picture (\"string filename\") -> it changes nothing\n");
  }
  for (const std::string light :
       {"LightSource \"projection\"", "AreaLightSource \"diffuse\" #\n"}) {
    const auto scene =
        testing::value_of(load_world(light + " \"string filter\" \"bilinear\" Shape \"disk\""));
    EXPECT_THAT(remarks_of(scene), HasSubstr(" \"string filter\" without a picture"));
    EXPECT_THAT(remarks_of(scene), ::testing::Not(HasSubstr("not known")));
  }
  // Parameters of an Attribute directive may stay unused.
  const auto scene = testing::value_of(
      load_world("Attribute \"light\" \"string filter\" \"bilinear\" LightSource \"infinite\""));
  EXPECT_EQ(remarks_of(scene), "");
}

// The light is equal in all directions, so no transform changes it.
TEST(PbrtLights, GoniometricLightsWithoutAFileTakeAnyTransform) {
  const auto scene = testing::value_of(
      load_world("Translate 1 2 3 Scale 1 -2 3 Rotate 40 1 2 3 LightSource \"goniometric\" "
                 "\"float power\" 100"));
  EXPECT_EQ(remarks_of(scene), "");
  const auto made = testing::value_of(
      GoniometricLight::create(std::get<GoniometricLightParams>(scene.lights.at(0).params)));
  EXPECT_EQ(made.params().position_m, Vec3(1, 2, 3));
  for (const Vec3& way : {Vec3{1, 0, 0}, {0, .6, -.8}, {0, 0, 1}})
    EXPECT_NEAR(made.intensity(way).g, 100 / (4 * std::numbers::pi), 1e-12);
}

TEST(PbrtLights, InvalidLevelsAreErrors) {
  const std::pair<const char*, const char*> kCases[] = {
      {"LightSource \"point\" \"rgb I\" [1 -1 1]", "\"rgb I\" = [1 -1 1], allowed: not negative"},
      {"LightSource \"point\" \"float scale\" -2", "\"float scale\" = -2, allowed: not negative"},
      {"LightSource \"point\" \"float power\" -2", "\"float power\" = -2, allowed: not negative"},
      {"LightSource \"point\" \"rgb I\" [1e308 1 1] \"float scale\" 1e308",
       "the light's level, \"I\" times \"scale\" = (inf, 1e+308, "
       "1e+308)"},
      {"LightSource \"point\" \"rgb I\" [0 0 0] \"float power\" 10",
       "\"float power\" = 10 lm for a light of luminance 0, allowed: 0, which counts as not given"},
      {"LightSource \"distant\" \"float scale\" 0 \"float illuminance\" 10",
       "\"float illuminance\" = 10 lx for a light of luminance 0, allowed: "
       "0"},
      {"LightSource \"infinite\" \"rgb L\" [0 0 0] \"float illuminance\" 10",
       "\"float illuminance\" = 10 lx for a light of luminance 0"},
      {"AreaLightSource \"diffuse\" \"rgb L\" [0 0 0] \"float power\" 1 Shape \"disk\"",
       "\"float power\" = 1 lm for a light of luminance 0"},
      {"LightSource \"point\" \"blackbody I\" 0", "black body of 0 K, allowed: [100, 1e7] K"},
      {"LightSource \"point\" \"spectrum I\" [400 1 400 2]", "wavelength 400 nm follows 400 nm"},
      {"LightSource \"point\" \"spectrum I\" [400 1 500]", "has 3 numbers, expected pairs"},
      {"LightSource \"point\" \"spectrum I\" [400 1 500 -1]",
       "value -1 at 500 nm, allowed: finite, not negative"},
      {"LightSource \"spot\" \"float coneangle\" 0",
       "\"float coneangle\" = 0 degrees, allowed (0, 180]"},
      {"LightSource \"spot\" \"float conedeltaangle\" 40", "allowed [0, coneangle], which is 30"},
      {"LightSource \"spot\" \"point3 to\" [0 0 0]", "\"point3 to\" = (0, 0, 0) and"},
      {"LightSource \"distant\" \"point3 to\" [0 0 0]", "\"point3 to\" = (0, 0, 0) and"},
      {"LightSource \"lamp\"", "unknown light \"lamp\", expected one of point spot distant"},
      {"AreaLightSource \"lamp\" Shape \"disk\"",
       "unknown area light \"lamp\", expected \"diffuse\""},
  };
  for (const auto& [text, expected] : kCases) {
    EXPECT_THAT(world_error_of(text), StartsWith("scene.pbrt:1:")) << text;
    EXPECT_THAT(world_error_of(text), HasSubstr(expected)) << text;
  }
}

TEST(PbrtLights, ErrorsStandAtTheParameterThatIsWrong) {
  // Columns of the text, after "WorldBegin ".
  const std::pair<const char*, const char*> kCases[] = {
      {"LightSource \"spot\" \"float coneangle\" 0",
       "1:31: \"float coneangle\" = 0 degrees, allowed (0, 180]"},
      {"LightSource \"spot\" \"float coneangle\" 20 \"float conedeltaangle\" 40",
       "1:52: \"float conedeltaangle\" = 40 degrees, allowed [0, coneangle], which is 20"},
      {"LightSource \"spot\" \"float coneangle\" 3",
       "1:31: \"float conedeltaangle\" = 5 degrees unless it is given, allowed [0, coneangle], "
       "which is 3"},
      {"LightSource \"spot\" \"point3 from\" [1 2 3] \"point3 to\" [1 2 3]",
       "1:53: \"point3 to\" = (1, 2, 3) and \"from\" = (1, 2, 3), which are (0, 0, 0) m apart"},
      {"LightSource \"spot\" \"point3 from\" [0 0 1]", "1:31: \"point3 to\" = (0, 0, 1)"},
      {"LightSource \"distant\" \"point3 to\" [0 0 0]", "1:34: \"point3 to\" = (0, 0, 0)"},
      {"LightSource \"point\" \"float scale\" 1e39",
       "1:32: the light's level, \"I\" times \"scale\" = (1e+39, 1e+39, 1e+39), allowed: each "
       "channel finite, at most 3.4e+38"},
      {"LightSource \"point\" \"rgb I\" [1e39 1 1]", "1:32: the light's level, "},
      {"LightSource \"infinite\" \"rgb L\" [1e30 1 1] \"float scale\" 1e30",
       "1:54: the light's level, "},
      {"LightSource \"distant\" \"float illuminance\" 1e39", "1:34: the light's level, "},
      {"LightSource \"projection\" \"float fov\" 1e-150",
       "1:37: \"float fov\" = 1e-150 degrees: projection.fov = "},
      {"LightSource \"projection\" \"float fov\" 30 \"float scale\" 1e39",
       "1:52: the light's level, "},
      {"AreaLightSource \"diffuse\" \"float scale\" 1e39 Shape \"disk\"",
       "1:38: the light's level, "},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_THAT(world_error_of(text), StartsWith(std::string("scene.pbrt:") + expected)) << text;
}

TEST(PbrtLights, LightsAndAreaLightsHaveNames) {
  const auto scene = testing::value_of(load_world(
      "LightSource \"point\" \"string name\" \"lamp \xc3\xbc\" LightSource \"point\" "
      "Attribute \"light\" \"string name\" \"all others\" LightSource \"distant\" "
      "AreaLightSource \"diffuse\" Shape \"disk\" "
      "AreaLightSource \"diffuse\" \"string name\" \"panel\" Shape \"disk\" Shape \"disk\""));
  ASSERT_EQ(scene.lights.size(), 3U);
  EXPECT_EQ(scene.lights[0].name, "lamp \xc3\xbc");
  EXPECT_EQ(scene.lights[1].name, "");
  EXPECT_EQ(scene.lights[2].name, "all others");
  ASSERT_EQ(scene.shapes.size(), 3U);
  EXPECT_EQ(scene.shapes[0].emission->name, "all others");
  EXPECT_EQ(scene.shapes[1].emission->name, "panel");
  EXPECT_EQ(scene.shapes[2].emission->name, "panel");
  EXPECT_TRUE(scene.remarks.empty());
}

TEST(PbrtLights, NamesArePrintableAndShort) {
  const auto named = [](const std::string& name) {
    return world_error_of("LightSource \"point\" \"string name\" \"" + name + "\"");
  };
  EXPECT_EQ(named(std::string(256, 'x')), "");
  EXPECT_THAT(named(std::string(257, 'x')),
              AllOf(StartsWith("scene.pbrt:1:32: \"string name\" = \"xxx"),
                    HasSubstr("257 bytes, allowed: 1 to 256 bytes of UTF-8 without control")));
  EXPECT_THAT(named(""), StartsWith("scene.pbrt:1:32: \"string name\" = \"\", 0 bytes, allowed"));
  EXPECT_THAT(named("a\tb"), StartsWith("scene.pbrt:1:32: \"string name\" = \"a?b\""));
  EXPECT_THAT(named("\xff"), StartsWith("scene.pbrt:1:32: \"string name\" = \"?\""));
  EXPECT_THAT(world_error_of("AreaLightSource \"diffuse\" \"string name\" \"\" Shape \"disk\""),
              StartsWith("scene.pbrt:1:38: \"string name\""));
}

TEST(PbrtLights, AnEmittingSphereUnderUnequalScaleIsRefusedAtTheShape) {
  EXPECT_THAT(world_error_of("Scale 1 2 1 AreaLightSource \"diffuse\" Shape \"sphere\""),
              StartsWith("scene.pbrt:1:50: "));
  EXPECT_EQ(world_error_of("Scale 1 2 1 Shape \"sphere\""), "");
}

}  // namespace
}  // namespace lucerna

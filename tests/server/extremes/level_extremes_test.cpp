// Row 18: `power` and `illuminance` of lights whose integral is zero or nearly zero.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/extremes_sweep.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/server/files/photometric_texts.h"
#include "tests/server/files/picture_texts.h"

namespace lucerna::testing {
namespace {

constexpr double kWanted = 100;

/// The factor that multiplies a light's level, all in float.  [Pharr23, A.4.4]
float textbook_level(double wanted, double integral) {
  return static_cast<float>(wanted) / static_cast<float>(integral);
}

/// Compares the flux with the requested power where the light was made.  Where the light was
/// refused, no float can hold the required level.
void compare_power(Sweep& sweep, const std::string& text, const FileScene& loaded, double level,
                   const std::string& at) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (loaded.status.ok()) {
    EXPECT_LE(level, kLargest * (1 + 1e-6)) << text;
    sweep.compare(flux_lm(*loaded.scene), kWanted, at);
  } else {
    EXPECT_GT(level, kLargest * (1 - 1e-6)) << text << ": " << loaded.status;
    EXPECT_EQ(refusal(text, "\"float power\"", loaded), "error with file, line and column");
  }
}

TEST(LevelExtremes, LightsWithAnIntegralOfZero) {
  Sweep sweep(18, "requested power or illuminance of a light whose integral is 0",
              "black levels, scale 0, black pictures, spectra and photometric files, no light on "
              "the side that counts, no area, cone of 0",
              "answer");
  const std::string black = even_pfm(4, 4, 0);
  // Lit only in the lower half of the sky, and only below the xy plane of a square of directions.
  std::vector<float> low(std::size_t{3} * 4 * 4, 0);
  std::fill(low.begin() + 3 * 4 * 2, low.end(), 1.0F);
  std::vector<float> corner(std::size_t{3} * 4 * 4, 0);
  corner[0] = corner[1] = corner[2] = 1;
  Ies ies_black, ies_up;
  ies_black.candela = "0 0 0\n";
  ies_up.angles = "90 135 180\n0\n";
  Ldt ldt_black;
  ldt_black.intensities = {"0", "0", "0"};
  const std::map<std::string, std::string> files{{"black.pfm", black},
                                                 {"even.pfm", even_pfm(4, 4, 1)},
                                                 {"low.pfm", pfm(4, 4, low)},
                                                 {"corner.pfm", pfm(4, 4, corner)},
                                                 {"black.ies", ies_black.text()},
                                                 {"up.ies", ies_up.text()},
                                                 {"black.ldt", ldt_black.text()}};

  const std::string power = " \"float power\" 100 ", lux = " \"float illuminance\" 100 ";
  const std::string area = "AreaLightSource \"diffuse\"" + power;
  const std::string portal = " \"point3 portal\" [-1 -1 1  -1 1 1  1 1 1  1 -1 1] ";
  const std::string kCases[] = {
      "LightSource \"point\" \"rgb I\" [0 0 0]" + power,
      "LightSource \"point\" \"float scale\" 0" + power,
      "LightSource \"point\" \"spectrum I\" [400 0 700 0]" + power,
      "LightSource \"point\" \"spectrum I\" [100 5 200 5]" + power,
      "LightSource \"spot\" \"rgb I\" [0 0 0]" + power,
      "LightSource \"spot\" \"float scale\" 0 \"float coneangle\" 180" + power,
      "LightSource \"distant\" \"rgb L\" [0 0 0]" + lux,
      "LightSource \"distant\" \"spectrum L\" [400 0 700 0] \"float angulardiameter\" 1" + lux,
      "LightSource \"infinite\" \"rgb L\" [0 0 0]" + lux,
      "LightSource \"infinite\" \"float scale\" 0" + portal + lux,
      "LightSource \"infinite\" \"string filename\" \"black.pfm\"" + lux,
      "LightSource \"infinite\" \"string filename\" \"corner.pfm\"" + lux,
      "LightSource \"infinite\" \"string filename\" \"low.pfm\" \"string mapping\" \"latlong\"" +
          lux,
      "LightSource \"infinite\" \"string filename\" \"black.pfm\" \"string filter\" \"bilinear\"" +
          portal + lux,
      "LightSource \"infinite\" \"string filename\" \"even.pfm\" \"float scale\" 0" + lux,
      "LightSource \"goniometric\" \"string filename\" \"black.pfm\"" + power,
      "LightSource \"goniometric\" \"string filename\" \"black.pfm\" \"string mapping\" "
      "\"latlong\" "
      "\"string filter\" \"bilinear\"" +
          power,
      "LightSource \"goniometric\" \"string filename\" \"black.ies\"" + power,
      "LightSource \"goniometric\" \"string filename\" \"black.ldt\"" + power,
      "LightSource \"goniometric\" \"float scale\" 0" + power,
      "LightSource \"projection\" \"string filename\" \"black.pfm\"" + power,
      "LightSource \"projection\" \"string filename\" \"black.pfm\" \"string filter\" "
      "\"bilinear\"" +
          power,
      "LightSource \"projection\" \"string filename\" \"black.pfm\" \"string projection\" "
      "\"orthographic\"" +
          power,
      "LightSource \"projection\" \"float scale\" 0" + power,
      area + "\"rgb L\" [0 0 0]\nShape \"sphere\"",
      area + "\"float scale\" 0\nShape \"disk\"",
      area + "\"string filename\" \"black.pfm\"\nShape \"cylinder\"",
      area + "\"string profile\" \"black.ies\"\nShape \"disk\"",
      area + "\"string profile\" \"up.ies\"\nShape \"disk\"",
      area +
          "\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 1 1 2 2 2] \"integer indices\" [0 1 2]",
      area +
          "\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 1 1] \"integer indices\" [0 1 1 0 0 0]",
      area + "\nShape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]",
  };
  const std::string same = "error with file, line and column";
  for (const std::string& text : kCases) {
    const std::string mistake = text.find("\"float power\"") != std::string::npos
                                    ? "\"float power\""
                                    : "\"float illuminance\"";
    const std::string said = refusal(text, mistake, scene_of(text, files));
    EXPECT_EQ(said, same) << text;
    sweep.answer(said);
  }
  // Refused by themselves, whatever level is requested.
  const std::pair<const char*, std::string> kDegenerate[] = {
      {"\"float coneangle\" 0", "LightSource \"spot\" \"float coneangle\" 0" + power},
      {"\"float fov\" 0", "LightSource \"projection\" \"float fov\" 0" + power},
      {"\"float extent\" 0",
       "LightSource \"projection\" \"string projection\" \"orthographic\" \"float extent\" 0" +
           power},
      {"\"float angulardiameter\" 0", "LightSource \"distant\" \"float angulardiameter\" 0" + lux},
      {"\"float radius\" 0", area + "\nShape \"disk\" \"float radius\" 0"},
      {"\"float innerradius\" 1", area + "\nShape \"disk\" \"float innerradius\" 1"},
      {"Scale 1 0 1", area + "\nScale 1 0 1 Shape \"sphere\""},
  };
  for (const auto& [mistake, text] : kDegenerate) {
    const std::string said = refusal(text, mistake, scene_of(text));
    EXPECT_EQ(said, same) << text;
    sweep.answer(said);
  }
  // For any light, the level is the requested power divided by an integral of 0.
  sweep.textbook_answer(std::isinf(textbook_level(kWanted, 0)) ? "infinite radiance" : "finite");
  sweep.expect_answers(same);
}

TEST(LevelExtremes, PowerOfNarrowSpots) {
  Sweep sweep(18, "requested power of a spot, half-angle",
              "180 ... 1e-18 degrees, and 1e-30 refused", "flux against the requested flux");
  for (const double degrees : {180.0, 90.0, 30.0, 1.0, 0.05, 0.01, 1e-3, 1e-5, 1e-8, 1e-12, 1e-15,
                               1e-17, 1e-18, 1e-19, 1e-20, 1e-30}) {
    const std::string angle = fmt::format("{}", degrees);
    const std::string text = "LightSource \"spot\" \"float coneangle\" " + angle +
                             " \"float conedeltaangle\" 0 \"float power\" 100";
    const double half = std::sin(degrees * kPi / 360);
    const double solid_angle = 4 * kPi * half * half;
    compare_power(sweep, text, scene_of(text), kWanted / solid_angle, angle);
    const float cos = std::cos(static_cast<float>(degrees * kPi / 180));
    sweep.compare_textbook(
        textbook_level(kWanted, 2 * std::numbers::pi_v<float> * (1 - cos)) * solid_angle, kWanted);
  }
  sweep.expect_within(1e-12);
}

TEST(LevelExtremes, PowerOfShapesOfAnySize) {
  Sweep sweep(18, "requested power of an area light, size", "1e-30 ... 1e29 m",
              "flux against the requested flux");
  const std::string area = "AreaLightSource \"diffuse\" \"float power\" 100\n";
  for (int exponent = -30; exponent <= 29; ++exponent) {
    const std::string s = fmt::format("1e{}", exponent);
    const double size = std::stod(s);
    struct Case {
      std::string shape;
      double area;  // at size 1
    };
    const Case kCases[] = {
        {"Shape \"disk\" \"float radius\" " + s, kPi},
        {"Shape \"sphere\" \"float radius\" " + s, 4 * kPi},
        {"Shape \"cylinder\" \"float radius\" " + s + " \"float zmin\" 0 \"float zmax\" " + s,
         2 * kPi},
    };
    for (const Case& c : kCases) {
      const double level = kWanted / (kPi * c.area) / size / size;
      compare_power(sweep, area + c.shape, scene_of(area + c.shape), level, c.shape);
      const float side = static_cast<float>(size);
      const float lumens = std::numbers::pi_v<float> * static_cast<float>(c.area) * side * side;
      sweep.compare_textbook(textbook_level(kWanted, lumens) * (kPi * c.area) * size * size,
                             kWanted);
    }
  }
  sweep.expect_within(1e-12);
}

TEST(LevelExtremes, PowerOfMeshesOfAnySize) {
  Sweep sweep(18, "requested power of a triangle or patch, size", "1e-30 ... 1e29 m",
              "flux against the requested flux");
  const std::string area = "AreaLightSource \"diffuse\" \"float power\" 100\n";
  for (int exponent = -30; exponent <= 29; ++exponent) {
    const std::string s = fmt::format("1e{}", exponent);
    const double size = std::stod(s);
    const std::string corners = "[0 0 0 " + s + " 0 0 0 " + s + " 0 ";
    const std::pair<std::string, double> kCases[] = {
        {"Shape \"trianglemesh\" \"point3 P\" " + corners + "]", 0.5},
        {"Shape \"bilinearmesh\" \"point3 P\" " + corners + s + " " + s + " 0]", 1},
    };
    for (const auto& [shape, unit] : kCases) {
      const double level = kWanted / (kPi * unit) / size / size;
      compare_power(sweep, area + shape, scene_of(area + shape), level, shape);
      const auto side = static_cast<float>(size);
      const float lumens = std::numbers::pi_v<float> * static_cast<float>(unit) * side * side;
      sweep.compare_textbook(textbook_level(kWanted, lumens) * (kPi * unit) * size * size, kWanted);
    }
  }
  sweep.expect_within(1e-12);
}

TEST(LevelExtremes, PowerOfDimAndBrightPictures) {
  Sweep sweep(18, "requested power of a picture, texels", "1e-45 ... 3e38",
              "flux against the requested flux");
  struct Case {
    const char* text;
    double integral;  // of texels equal to 1
  };
  const Case kLights[] = {
      {"LightSource \"goniometric\" \"string filename\" \"a.pfm\" \"float power\" 100", 4 * kPi},
      {"LightSource \"goniometric\" \"string filename\" \"a.pfm\" \"string mapping\" \"latlong\" "
       "\"string filter\" \"bilinear\" \"float power\" 100",
       4 * kPi},
      // One side of a cube.
      {"LightSource \"projection\" \"string filename\" \"a.pfm\" \"string filter\" \"bilinear\" "
       "\"float power\" 100",
       4 * kPi / 6},
      {"LightSource \"projection\" \"string filename\" \"a.pfm\" \"string projection\" "
       "\"orthographic\" \"float power\" 100",
       1},
      {"AreaLightSource \"diffuse\" \"string filename\" \"a.pfm\" \"float power\" 100\n"
       "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]",
       kPi},
  };
  for (const float texel : {1e-45F, 1e-40F, 1e-38F, 1e-36F, 1e-30F, 1e-20F, 1e-10F, 1.0F, 1e10F,
                            1e20F, 1e30F, 1e37F, 3.4e38F})
    for (const auto& [text, integral] : kLights) {
      const double level = kWanted / (integral * double{texel});
      compare_power(sweep, text, scene_of(text, {{"a.pfm", even_pfm(16, 16, texel)}}), level,
                    fmt::format("{}", texel));
      float sum = 0;
      for (int i = 0; i < 256; ++i) sum += texel;
      sweep.compare_textbook(
          textbook_level(kWanted, sum / 256 * integral) * (integral * double{texel}), kWanted);
    }
  // The projection has 16 texels a side.  Its flux is their sum, each accurate to a float's digits.
  sweep.expect_within(1e-7);
}

TEST(LevelExtremes, PowerOfDimAndBrightLuminaires) {
  Sweep sweep(18, "requested power of a photometric file, intensities", "1e-300 ... 1e300 cd",
              "flux against the requested flux");
  for (const int exponent : {-300, -100, -45, -38, -30, -10, 0, 10, 30, 38, 39, 100, 290})
    for (const bool panel : {false, true}) {
      Ies ies;
      const std::string e = fmt::format("e{}", exponent);
      ies.candela = "3" + e + " 2" + e + " 1" + e + "\n";
      const std::string text =
          panel ? "AreaLightSource \"diffuse\" \"string profile\" \"a.ies\" \"float power\" 100\n"
                  "Shape \"disk\""
                : "LightSource \"goniometric\" \"string filename\" \"a.ies\" \"float power\" 100";
      const FileScene loaded = scene_of(text, {{"a.ies", ies.text()}});
      // A level that no float can hold is refused.
      const std::string at = fmt::format("{}{}", e, panel ? ", panel" : "");
      if (loaded.status.ok())
        sweep.compare(flux_lm(*loaded.scene), kWanted, at);
      else
        EXPECT_EQ(refusal(text, "\"float power\"", loaded), "error with file, line and column")
            << at << loaded.status;
      const auto cd = static_cast<float>(std::stod("3" + e));
      sweep.compare_textbook(textbook_level(kWanted, cd) * std::stod("3" + e), kWanted);
    }
  sweep.expect_within(1e-12);
}

}  // namespace
}  // namespace lucerna::testing

// Materials, textures and spectra.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
using testing::load_world;
using testing::remarks_of;
using testing::world_error_of;

/// The reflectance of the disk after `text`, and the remarks.
std::pair<Rgb<double>, std::string> surface(const std::string& text) {
  const auto scene = load_world(text + " Shape \"disk\"");
  if (!scene.ok() || scene->shapes.size() != 1) {
    ADD_FAILURE() << text << ": " << scene.status();
    return {};
  }
  return {scene->materials.at(scene->shapes[0].material).reflectance, remarks_of(*scene)};
}

TEST(PbrtMaterials, DiffuseTakesRgbFloatAndConstantSpectra) {
  const std::pair<const char*, Rgb<double>> kCases[] = {
      {"", Rgb<double>(.5)},
      {"Material \"diffuse\"", Rgb<double>(.5)},
      {"Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]", {.1, .2, .3}},
      {"Material \"diffuse\" \"float reflectance\" .7", Rgb<double>(.7)},
      {"Material \"diffuse\" \"spectrum reflectance\" [300 .3 900 .3]", Rgb<double>(.3)},
      {"Attribute \"material\" \"rgb reflectance\" [.1 .1 .1] Material \"diffuse\"",
       Rgb<double>(.1)},
      {"Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [.2 .4 .6] Texture \"s\" "
       "\"spectrum\" "
       "\"scale\" \"texture tex\" \"t\" \"float scale\" .5 Material \"diffuse\" \"texture "
       "reflectance\" \"s\"",
       {.1, .2, .3}},
      {"Texture \"f\" \"float\" \"constant\" \"float value\" 3 Texture \"s\" \"spectrum\" "
       "\"scale\" "
       "\"rgb tex\" [.1 .2 .3] \"texture scale\" \"f\" Material \"diffuse\" \"texture "
       "reflectance\" \"s\"",
       {.1 * 3, .2 * 3, .3 * 3}},
      {"Texture \"m\" \"spectrum\" \"mix\" \"rgb tex1\" [.2 .2 .2] \"rgb tex2\" [.6 .6 .6] \"float "
       "amount\" "
       ".25 Material \"diffuse\" \"texture reflectance\" \"m\"",
       Rgb<double>(.2 * .75 + .6 * .25)},
  };
  for (const auto& [text, expected] : kCases) {
    const auto [reflectance, remarks] = surface(text);
    EXPECT_EQ(reflectance, expected) << text;
    EXPECT_EQ(remarks, "") << text;
  }
}

TEST(PbrtMaterials, OthersBecomeDiffuseWithARemark) {
  const std::tuple<const char*, double, const char*> kCases[] = {
      {"Material \"coateddiffuse\" \"rgb reflectance\" [.2 .2 .2] \"float roughness\" 0", .2,
       "1:12 material \"coateddiffuse\" is not modelled -> diffuse, reflectance 0.2\n"},
      {"Material \"conductor\" \"rgb reflectance\" [.9 .9 .9]", .9,
       "1:12 material \"conductor\" is not modelled -> diffuse, reflectance 0.9\n"},
      {"Material \"conductor\"", .5,
       "1:12 material \"conductor\" is not modelled -> diffuse, reflectance 0.5\n"},
      {"Material \"dielectric\"", .5,
       "1:12 material \"dielectric\" is not modelled -> diffuse, reflectance 0.5\n"},
      {"Material \"diffuse\" \"rgb reflectance\" [2 2 2]", 1,
       "1:31 \"reflectance\" = [2 2 2] is not a valid reflectance -> clamped to [1 1 1]\n"},
      {"Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"x.png\" Material \"diffuse\" "
       "\"texture reflectance\" \"t\"",
       .5, "1:12 texture \"t\" (imagemap) is not modelled -> constant 0.5\n"},
      {"Material \"diffuse\" \"spectrum reflectance\" \"x.spd\"", .5,
       "1:31 spectrum \"reflectance\" of a surface is not modelled -> grey 0.5\n"},
      {"Material \"diffuse\" \"string normalmap\" \"x.png\"", .5,
       "1:31 \"normalmap\" of material \"diffuse\" is not modelled -> the surface without it\n"},
  };
  for (const auto& [text, expected, remark] : kCases) {
    const auto [reflectance, remarks] = surface(text);
    EXPECT_EQ(reflectance, Rgb<double>(expected)) << text;
    EXPECT_EQ(remarks, remark) << text;
  }
}

TEST(PbrtMaterials, MixIsItsFirstPart) {
  const auto [reflectance, remarks] = surface(
      "Material \"mix\" \"string materials\" [\"a\" \"b\"] MakeNamedMaterial \"a\" \"string type\" "
      "\"diffuse\" "
      "\"rgb reflectance\" [.3 .3 .3] MakeNamedMaterial \"b\" \"string type\" \"conductor\"");
  EXPECT_EQ(reflectance, Rgb<double>(.3));
  EXPECT_EQ(remarks,
            "1:12 material \"mix\" is not modelled -> its first part, diffuse, reflectance 0.3\n");
}

TEST(PbrtMaterials, NamedMaterialsMayBeUsedBeforeTheirDefinition) {
  const auto scene = load_world(
      "NamedMaterial \"m\" Shape \"disk\" MakeNamedMaterial \"m\" \"string type\" \"diffuse\" "
      "\"rgb reflectance\" [.3 .3 .3] Shape \"disk\" Material \"diffuse\" Material \"conductor\"");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->materials.size(), 1U);  // unused materials are not built
  EXPECT_EQ(scene->materials[scene->shapes[1].material].reflectance, Rgb<double>(.3));
  EXPECT_EQ(remarks_of(*scene), "");
}

TEST(PbrtMaterials, InterfacesAreInvisible) {
  const auto scene = load_world(
      "AreaLightSource \"diffuse\" Material \"interface\" Shape \"disk\"\nMaterial \"diffuse\" "
      "Shape \"sphere\"");
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->shapes.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<SphereParams>(scene->shapes[0].geometry));
  EXPECT_EQ(
      remarks_of(*scene),
      "1:59 a shape with the material \"interface\", which bounds a medium -> left out, its light "
      "too, as in pbrt-v4\n");
}

TEST(PbrtMaterials, InvalidMaterialsAreErrors) {
  const std::pair<const char*, const char*> kCases[] = {
      {"Material \"gold\"", "unknown material \"gold\", expected one of diffuse"},
      {"MakeNamedMaterial \"m\"", "material \"m\" lacks \"string type\""},
      {"MakeNamedMaterial \"m\" \"string type\" \"diffuse\" MakeNamedMaterial \"m\" \"string "
       "type\" \"diffuse\"",
       "material \"m\" is already defined, at scene.pbrt:1:12"},
      {"Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"disk\"",
       "texture \"t\" is not defined"},
      {"MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"] "
       "NamedMaterial \"m\" Shape \"disk\"",
       "is a mix of itself"},
      {"Texture \"t\" \"spectrum\" \"constant\" Texture \"t\" \"spectrum\" \"constant\"",
       "is already defined"},
      {"Material \"diffuse\" \"spectrum reflectance\" [500 1 400 1] Shape \"disk\"",
       "wavelength 400 nm follows 500 nm"},
      {"Texture \"t\" \"spectrum\" \"wood\"", "unknown texture class \"wood\""},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_THAT(world_error_of(text), HasSubstr(expected)) << text;
}

}  // namespace
}  // namespace lucerna

// Materials, textures and spectra.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tuple>

#include "pbrt_fixture.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::load_world;
using testing::remarks_of;
using testing::world_error_of;

/// The reflectance of the disk after `text`, and the remarks.
std::pair<Rgb, std::string> surface(const std::string& text) {
  const auto scene = load_world(text + " Shape \"disk\"");
  if (!scene.ok() || scene->shapes.size() != 1) {
    ADD_FAILURE() << text << ": " << scene.status();
    return {};
  }
  const Rgb* reflectance = scene->materials.at(scene->shapes[0].material).plain_diffuse();
  if (reflectance == nullptr) {
    ADD_FAILURE() << text << ": not diffuse without textures";
    return {};
  }
  return {*reflectance, remarks_of(*scene)};
}

/// The parameters of the disk's material after `text`, which must have no remark.
template <typename Params>
Params params_of(const std::string& text) {
  const auto scene = load_world(text + " Shape \"disk\"");
  if (!scene.ok() || scene->shapes.size() != 1) {
    ADD_FAILURE() << text << ": " << scene.status();
    return {};
  }
  EXPECT_EQ(remarks_of(*scene), "") << text;
  const auto* params = std::get_if<Params>(&scene->materials.at(scene->shapes[0].material).params);
  EXPECT_NE(params, nullptr) << text;
  return params != nullptr ? *params : Params{};
}

TEST(PbrtMaterials, DiffuseTakesRgbFloatAndConstantSpectra) {
  const std::pair<const char*, Rgb> kCases[] = {
      {"", Rgb(.5)},
      {"Material \"diffuse\"", Rgb(.5)},
      {"Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]", {.1, .2, .3}},
      {"Material \"diffuse\" \"float reflectance\" .7", Rgb(.7)},
      {"Material \"diffuse\" \"spectrum reflectance\" [300 .3 900 .3]", Rgb(.3)},
      {"Attribute \"material\" \"rgb reflectance\" [.1 .1 .1] Material \"diffuse\"", Rgb(.1)},
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
       Rgb(.2 * .75 + .6 * .25)},
  };
  for (const auto& [text, expected] : kCases) {
    const auto [reflectance, remarks] = surface(text);
    EXPECT_EQ(reflectance, expected) << text;
    EXPECT_EQ(remarks, "") << text;
  }
}

// The values are sums over steps of 0.001 nm, by numpy, of the same CIE tables.
TEST(PbrtMaterials, ASpectrumBecomesItsColourUnderD65) {
  const std::pair<const char*, Rgb> kCases[] = {
      {"\"spectrum reflectance\" [400 .2 700 .8]", {0.68232741, 0.48638649, 0.28096239}},
      {"\"spectrum reflectance\" [360 .1 560 .1 600 .7 830 .7]",
       {0.80936906, 0.13444573, 0.08145703}},
      {"\"spectrum reflectance\" [360 .2 480 .2 500 .6 550 .6 570 .2 830 .2]",
       {0.04592897, 0.52069031, 0.19936398}},
  };
  for (const auto& [text, expected] : kCases) {
    const auto [reflectance, remarks] = surface(std::string("Material \"diffuse\" ") + text);
    constexpr double kTolerance = 1e-7;
    EXPECT_NEAR(reflectance.r, expected.r, kTolerance) << text;
    EXPECT_NEAR(reflectance.g, expected.g, kTolerance) << text;
    EXPECT_NEAR(reflectance.b, expected.b, kTolerance) << text;
    EXPECT_EQ(remarks, "") << text;
  }
}

TEST(PbrtMaterials, ASpectrumOutsideOfTheRgbGamutIsClampedWithARemark) {
  const auto [reflectance, remarks] =
      surface("Material \"diffuse\" \"spectrum reflectance\" [360 0 620 0 620.0001 1 830 1]");
  EXPECT_NEAR(reflectance.r, 0.44005822, 1e-6);
  EXPECT_EQ(reflectance.g, 0);
  EXPECT_EQ(reflectance.b, 0);
  EXPECT_EQ(remarks,
            "1:31 the colour of \"reflectance\" = [0.4401 -0.03605 -0.004415] is not a valid "
            "reflectance -> clamped to [0.4401 0 0]\n");
}

TEST(PbrtMaterials, AReflectanceMayBeAFileOfSamples) {
  const testing::SceneFiles files;
  files.write("leaf.spd", "# leaf\n400 .2\n700 .8\n");
  files.write("scene.pbrt",
              "WorldBegin Material \"diffuse\" \"spectrum reflectance\" \"leaf.spd\" "
              "Shape \"disk\"");
  const auto scene = testing::value_of(files.load("scene.pbrt"));
  const Rgb* reflectance = scene.materials.at(scene.shapes.at(0).material).plain_diffuse();
  ASSERT_NE(reflectance, nullptr);
  EXPECT_NEAR(reflectance->g, 0.48638649, 1e-7);
  EXPECT_EQ(remarks_of(scene), "");
  EXPECT_THAT(
      world_error_of("Material \"diffuse\" \"spectrum reflectance\" \"x.spd\" Shape \"disk\""),
      AllOf(HasSubstr("scene.pbrt:1:31: "), HasSubstr("x.spd")));
}

TEST(PbrtMaterials, OthersBecomeDiffuseWithARemark) {
  const std::tuple<const char*, double, const char*> kCases[] = {
      {"Material \"hair\"", .5,
       "1:12 material \"hair\" is not modelled -> diffuse, with its reflectance or 0.5\n"},
      {"Material \"subsurface\" \"rgb reflectance\" [.9 .9 .9]", .9,
       "1:12 material \"subsurface\" is not modelled -> diffuse, with its reflectance or 0.5\n"},
      {"Material \"diffuse\" \"rgb reflectance\" [2 2 2]", 1,
       "1:31 \"reflectance\" = [2 2 2] is not a valid reflectance -> clamped to [1 1 1]\n"},
      {"Texture \"t\" \"spectrum\" \"marble\" Material \"diffuse\" "
       "\"texture reflectance\" \"t\"",
       .5, "1:12 texture \"t\" (marble) is not modelled -> constant 0.5\n"},
      {"Material \"diffuse\" \"spectrum reflectance\" \"stdillum-A\"", .5,
       "1:31 \"stdillum-A\" is not the spectrum of a reflectance -> grey 0.5\n"},
      {"Material \"diffuse\" \"spectrum reflectance\" [300 2 900 2]", 1,
       "1:31 the colour of \"reflectance\" = [2 2 2] is not a valid reflectance -> clamped to [1 1 "
       "1]\n"},
      {"Material \"diffuse\" \"float displacement\" 1", .5, ""},
  };
  for (const auto& [text, expected, remark] : kCases) {
    const auto [reflectance, remarks] = surface(text);
    EXPECT_EQ(reflectance, Rgb(expected)) << text;
    EXPECT_EQ(remarks, remark) << text;
  }
}

TEST(PbrtMaterials, MetalsHaveTheIndexOfTheirSpectra) {
  const auto flat = params_of<MetalParams>(
      "Material \"conductor\" \"spectrum eta\" [360 .2 830 .2] \"spectrum k\" [360 3 830 3] "
      "\"float roughness\" .3 \"bool remaproughness\" false");
  for (const auto channel : {&Rgb::r, &Rgb::g, &Rgb::b}) {
    EXPECT_NEAR(flat.eta.constant.*channel, 0.2, 1e-5);
    EXPECT_NEAR(flat.k.constant.*channel, 3, 1e-4);
  }
  EXPECT_EQ(flat.roughness.u.constant, .3);
  EXPECT_EQ(flat.roughness.v.constant, .3);
  EXPECT_FALSE(flat.roughness.remap);
  // Copper is the default, and reflects red best.
  const auto copper = params_of<MetalParams>("Material \"conductor\" \"float uroughness\" .1");
  const auto named = params_of<MetalParams>(
      "Material \"conductor\" \"spectrum eta\" \"metal-Cu-eta\" \"spectrum k\" "
      "\"metal-Cu-k\"");
  EXPECT_EQ(copper.eta.constant, named.eta.constant);
  EXPECT_EQ(copper.k.constant, named.k.constant);
  EXPECT_EQ(copper.roughness.u.constant, .1);
  EXPECT_EQ(copper.roughness.v.constant, 0);
  EXPECT_GT(copper.k.constant.r, copper.k.constant.b);
  EXPECT_EQ(params_of<MetalParams>("Material \"conductor\" \"rgb reflectance\" [.9 .5 .1]")
                .reflectance->constant,
            (Rgb{.9, .5, .1}));
}

TEST(PbrtMaterials, OtherMaterialsKeepTheirParameters) {
  EXPECT_EQ(params_of<DielectricParams>("Material \"dielectric\"").eta.constant, 1.5);
  EXPECT_EQ(params_of<DielectricParams>("Material \"dielectric\" \"float eta\" 1.3 "
                                        "\"float roughness\" .2")
                .roughness.v.constant,
            .2);
  EXPECT_EQ(
      params_of<ThinDielectricParams>("Material \"thindielectric\" \"float eta\" 1.4").eta.constant,
      1.4);
  const auto leaf = params_of<DiffuseTransmissionParams>(
      "Material \"diffusetransmission\" \"rgb transmittance\" [.5 .5 .5] \"float scale\" .8");
  EXPECT_EQ(leaf.reflectance.constant, Rgb(.25));
  EXPECT_EQ(leaf.transmittance.constant, Rgb(.5));
  EXPECT_EQ(leaf.scale, .8);
  const auto paint = params_of<CoatedDiffuseParams>(
      "Material \"coateddiffuse\" \"rgb reflectance\" [.2 .2 .2] \"float roughness\" .1 "
      "\"float thickness\" .02 \"float eta\" 1.6");
  EXPECT_EQ(paint.reflectance.constant, Rgb(.2));
  EXPECT_EQ(paint.coat.roughness.u.constant, .1);
  EXPECT_EQ(paint.coat.thickness.constant, .02);
  EXPECT_EQ(paint.coat.eta.constant, 1.6);
  const auto lacquer = params_of<CoatedMetalParams>(
      "Material \"coatedconductor\" \"float conductor.roughness\" .2 "
      "\"float interface.roughness\" .05 \"float interface.eta\" 1.4");
  EXPECT_EQ(lacquer.metal.roughness.u.constant, .2);
  EXPECT_EQ(lacquer.coat.roughness.u.constant, .05);
  EXPECT_EQ(lacquer.coat.eta.constant, 1.4);
}

TEST(PbrtMaterials, MixesReferToTheirParts) {
  const auto scene = testing::value_of(load_world(
      "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .3 "
      "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [.3 .3 .3] "
      "MakeNamedMaterial \"b\" \"string type\" \"conductor\" Shape \"disk\""));
  const auto& mix = std::get<MixParams>(scene.materials.at(scene.shapes[0].material).params);
  EXPECT_EQ(*scene.materials[mix.materials[0]].plain_diffuse(), Rgb(.3));
  EXPECT_TRUE(std::holds_alternative<MetalParams>(scene.materials[mix.materials[1]].params));
  EXPECT_EQ(mix.amount.constant, .3);
}

TEST(PbrtMaterials, GlassesHaveTheIndexOfYellowLight) {
  const auto scene = testing::value_of(
      load_world("Material \"dielectric\" \"spectrum eta\" \"glass-BK7\" Shape \"disk\""));
  EXPECT_EQ(std::get<DielectricParams>(scene.materials[0].params).eta.constant, 1.5168);
  EXPECT_THAT(remarks_of(scene), HasSubstr("dispersion"));
}

TEST(PbrtMaterials, TexturesThatVaryBecomeNodes) {
  const auto scene = testing::value_of(
      load_world("Texture \"c\" \"spectrum\" \"checkerboard\" \"float uscale\" 8 "
                 "\"rgb tex1\" [.7 .7 .7] \"rgb tex2\" [.1 .1 .1] "
                 "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" .5 "
                 "Material \"diffuse\" \"texture reflectance\" \"s\" Shape \"disk\""));
  EXPECT_EQ(remarks_of(scene), "");
  EXPECT_EQ(scene.textures.size(), 2U);
  EXPECT_TRUE(scene.shapes[0].has_uv);
  const ColourValue& value =
      std::get<DiffuseParams>(scene.materials.at(scene.shapes[0].material).params).reflectance;
  EXPECT_EQ(scene.textures(value, {.uv = {0.05, 0.5}}), Rgb(.35));
  EXPECT_EQ(scene.textures(value, {.uv = {0.2, 0.5}}), Rgb(.05));
}

TEST(PbrtMaterials, NamedMaterialsMayBeUsedBeforeTheirDefinition) {
  const auto scene = testing::value_of(load_world(
      "NamedMaterial \"m\" Shape \"disk\" MakeNamedMaterial \"m\" \"string type\" \"diffuse\" "
      "\"rgb reflectance\" [.3 .3 .3] Shape \"disk\" Material \"diffuse\" Material \"conductor\""));
  EXPECT_EQ(scene.materials.size(), 1U);  // unused materials are not built
  EXPECT_EQ(*scene.materials[scene.shapes[1].material].plain_diffuse(), Rgb(.3));
  EXPECT_EQ(remarks_of(scene), "");
}

TEST(PbrtMaterials, DisplacementsAreBumps) {
  const auto scene = testing::value_of(load_world(
      "Texture \"h\" \"float\" \"bilerp\" Material \"diffuse\" \"texture displacement\" \"h\" "
      "Shape \"disk\""));
  EXPECT_EQ(scene.materials[0].bumps, 0);
  EXPECT_TRUE(scene.shapes[0].has_uv);
  EXPECT_EQ(scene.materials[0].plain_diffuse(), nullptr);
  EXPECT_EQ(remarks_of(scene), "");
}

TEST(PbrtMaterials, InterfacesAreInvisible) {
  const auto scene = testing::value_of(load_world(
      "AreaLightSource \"diffuse\" Material \"interface\" Shape \"disk\"\nMaterial \"diffuse\" "
      "Shape \"sphere\""));
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<SphereParams>(scene.shapes[0].geometry));
  EXPECT_EQ(
      remarks_of(scene),
      "1:59 a light whose shape has the material \"interface\" -> emits nothing, as in pbrt-v4\n"
      "1:59 a shape with the material \"interface\" that bounds no medium -> left out\n");
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
      {"Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"t\"",
       "texture \"t\" is not defined before this place"},
      {"Texture \"t\" \"spectrum\" \"imagemap\"", "lacks \"string filename\""},
      {"Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"", "none.png"},
      {"Texture \"t\" \"spectrum\" \"checkerboard\" \"integer dimension\" 4",
       "\"integer dimension\" = 4, allowed: 2, 3"},
      {"Texture \"t\" \"spectrum\" \"checkerboard\" \"string mapping\" \"cube\"",
       "\"string mapping\" = \"cube\", allowed: uv, spherical, cylindrical, planar"},
      {"Material \"dielectric\" \"float eta\" 0 Shape \"disk\"", "\"float eta\" = 0, allowed"},
      {"Material \"conductor\" \"float roughness\" -1 Shape \"disk\"",
       "\"float roughness\" = -1, allowed: at least 0"},
      {"Material \"conductor\" \"rgb reflectance\" [1 1 1] \"rgb eta\" [1 1 1] Shape \"disk\"",
       "are both given"},
      {"MakeNamedMaterial \"a\" \"string type\" \"diffuse\" Material \"mix\" "
       "\"string materials\" [\"a\"] Shape \"disk\"",
       "has 1 names, allowed: 2"},
  };
  for (const auto& [text, expected] : kCases)
    EXPECT_THAT(world_error_of(text), HasSubstr(expected)) << text;
}

}  // namespace
}  // namespace lucerna

// Factors of light levels: those of Blender's exporter, and scenes in the store that have them.
#include <gmock/gmock.h>

#include <numbers>

#include "gltf_fixture.h"
#include "server/gltf/blender_levels.h"
#include "server/scene/scene.h"
#include "server/store/scene_store.h"

namespace lucerna {
namespace {

using gltf::blender_level_factors;
using gltf::BlenderLightingMode;
using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using testing::Json;
using testing::message_of;
using testing::png;

constexpr double kPi = std::numbers::pi;

constexpr char kLevelsIes[] =
    "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 50\n0 90\n0\n200 100\n";

/// A scene with one light of each kind.  Each has the level 2, 1, 0.5.
void write_every_kind(const GltfFiles& files) {
  const Json colour = {1, 0.5, 0.25};
  GltfFile file;
  for (const char* type : {"point", "spot", "directional"}) {
    Json light = {{"type", type}, {"intensity", 2}, {"color", colour}};
    if (light["type"] == "spot") light["spot"] = Json::object();
    file.add_node(GltfFile::light_node(file.add_light(light)));
  }
  file.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array({{{"uri", "lamp.ies"}}});
  file.add_node(
      {{"extensions", {{"EXT_lights_ies", {{"light", 0}, {"multiplier", 2}, {"color", colour}}}}}});
  Json primitive = file.triangle();
  primitive["material"] = 0;
  file.json["materials"] = Json::array(
      {{{"emissiveFactor", colour},
        {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}}}}}});
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  file.json["images"] = Json::array({{{"uri", "face.png"}}});
  file.json["extensions"]["EXT_lights_image_based"]["lights"] =
      Json::array({{{"intensity", 2},
                    {"specularImageSize", 1},
                    {"specularImages", Json::array({{0, 0, 0, 0, 0, 0}})},
                    {"irradianceCoefficients", Json::array()}}});
  file.json["scenes"][0]["extensions"] = {{"EXT_lights_image_based", {{"light", 0}}}};
  files.write("lamp.ies", kLevelsIes);
  files.write("face.png", png(1, 1, {255, 255, 255, 255}));
  files.write("scene.gltf", file.text());
}

/// Compares the levels of the scene, to the last bit, with those of the file times factors.
void expect_factors(const LevelFactors& given, double lamps, double suns, double emission) {
  const GltfFiles files;
  write_every_kind(files);
  const auto scene = testing::value_of(files.load("scene.gltf", given));
  const Rgb level(2, 1, 0.5);
  ASSERT_EQ(scene.lights.size(), 5U);
  const auto& lights = scene.lights;
  EXPECT_EQ(std::get<PointLightParams>(lights[0].params).intensity_cd, level * lamps);
  EXPECT_EQ(std::get<SpotLightParams>(lights[1].params).intensity_cd, level * lamps);
  EXPECT_EQ(std::get<DistantLightParams>(lights[2].params).illuminance_lx, level * suns);
  EXPECT_EQ(std::get<GoniometricLightParams>(lights[3].params).intensity, level);
  EXPECT_EQ(std::get<ImageInfiniteLightParams>(lights[4].params).radiance_cd_m2, Rgb(2 * emission));
  EXPECT_EQ(scene.shapes.at(0).emission->radiance_cd_m2, level * emission);
}

TEST(GltfLevels, StandardFilesNeed683ForEmission) {
  expect_factors(blender_level_factors(BlenderLightingMode::kStandard), 1, 1, 683);
  expect_factors(blender_level_factors(BlenderLightingMode::kStandard, 341.5), 0.5, 0.5, 341.5);
}

TEST(GltfLevels, UnitlessFilesNeedOneFactor) {
  expect_factors(blender_level_factors(BlenderLightingMode::kUnitless), 683, 683, 683);
  expect_factors(blender_level_factors(BlenderLightingMode::kUnitless, 100), 100, 100, 100);
}

TEST(GltfLevels, LampsOfRawFilesHaveTheirWholePower) {
  expect_factors(blender_level_factors(BlenderLightingMode::kRaw), 683 / (4 * kPi), 683, 683);
  expect_factors(blender_level_factors(BlenderLightingMode::kRaw, 4 * kPi), 1, 4 * kPi, 4 * kPi);
}

TEST(GltfLevels, WithoutFactorsTheFilesNumbersHold) { expect_factors({}, 1, 1, 1); }

TEST(GltfLevels, LevelsThatAFactorMakesTooLargeAreRefused) {
  const GltfFiles files;
  GltfFile file;
  file.add_node(GltfFile::light_node(file.add_light({{"type", "point"}, {"intensity", 1e37}})));
  files.write("scene.gltf", file.text());
  EXPECT_TRUE(files.load("scene.gltf").ok());
  EXPECT_THAT(message_of(files.load("scene.gltf", {.lamps = 683}).status()),
              HasSubstr("scene.gltf#/extensions/KHR_lights_punctual/lights/0: intensity = "));
}

TEST(GltfLevels, EachSetOfFactorsIsASceneInTheStore) {
  const GltfFiles files;
  write_every_kind(files);
  const auto store = SceneStore::open({.root = files.path().string()}).value();
  const auto load = [&](std::optional<LevelFactors> factors) {
    return store->load("scene.gltf", {.factors = factors}).value();
  };
  const LoadedScene plain = load({}), bright = load(LevelFactors{1, 1, 683});
  EXPECT_EQ(plain.stored.scene->id(), scene_id(plain.stored.scene->report().assets));
  EXPECT_EQ(plain.stored.scene->report().level_factors, LevelFactors());
  EXPECT_NE(bright.stored.scene->id(), plain.stored.scene->id());
  EXPECT_EQ(bright.stored.scene->report().level_factors, (LevelFactors{1, 1, 683}));
  // Any of the three factors makes another scene.
  EXPECT_FALSE(load(LevelFactors{683, 1, 1}).already_loaded);
  EXPECT_FALSE(load(LevelFactors{1, 683, 1}).already_loaded);
  EXPECT_EQ(store->size(), 4U);

  EXPECT_EQ(load({}).stored.scene, plain.stored.scene);
  EXPECT_EQ(load(LevelFactors()).stored.scene, plain.stored.scene);
  EXPECT_EQ(load(LevelFactors{1, 1, 683}).stored.scene, bright.stored.scene);
  EXPECT_EQ(store->builds(), 4U);
}

}  // namespace
}  // namespace lucerna

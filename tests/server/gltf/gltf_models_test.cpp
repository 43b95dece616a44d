// The glTF models of Debian's package assimp-testmodels, good and deliberately broken.
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "gltf_fixture.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

const fs::path kModels = "/usr/share/assimp/models";

/// A part of the error of each broken model, by its path.
const std::map<std::string, std::string>& broken() {
  static const std::map<std::string, std::string> kBroken{
      // Version 1 of the format.
      {"glTF/BoxTextured-glTF-Binary/BoxTextured.glb", ": container version 1, allowed: 2"},
      {"glTF/BoxTextured-glTF-Embedded/BoxTextured.gltf", "#/asset/version: found \"1.0\""},
      {"glTF/BoxTextured-glTF-MaterialsCommon/BoxTextured.gltf", "#/asset/version: found \"1.0\""},
      {"glTF/BoxTextured-glTF/BoxTextured.gltf", "#/asset"},
      {"glTF/CesiumMilkTruck/CesiumMilkTruck.gltf", "#/asset/version: found 1, allowed: a string"},
      {"glTF/IncorrectVertexArrays/Cube_v1.gltf", "#/asset/version: found \"1.0\""},
      {"glTF/TwoBoxes/TwoBoxes.gltf", "#/asset/version: found \"1.0\""},
      // Version 2 with a defect.
      {"glTF2/BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf",
       "#/extensionsRequired/0: the file requires the extension \"KHR_technique_webgl\""},
      {"glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb",
       "#/accessors/2: element 0 has the value -inf, allowed: finite"},
      {"glTF2/IndexOutOfRange/AllIndicesOutOfRange.gltf",
       "#/meshes/0/primitives/0/indices: index 0 names vertex 65535, but there are 24 vertices"},
      {"glTF2/IndexOutOfRange/IndexOutOfRange.gltf",
       "#/meshes/0/primitives/0/indices: index 0 names vertex 255, but there are 24 vertices"},
      {"glTF2/MissingBin/BoxTextured.gltf", "#/buffers/0/uri: "},
      {"glTF2/RecursiveNodes/RecursiveNodes.gltf", "#/nodes/0: node 0 is beneath itself"},
      {"glTF2/SchemaFailures/sceneWrongType.gltf", "#/scene: found \"hello\""},
      {"glTF2/TestNoRootNode/NoScene.gltf", "#/scene: found 0, allowed: nothing"},
      {"glTF2/wrongTypes/badArray.gltf", "#/meshes/0/primitives: found an object"},
      {"glTF2/wrongTypes/badExtension.gltf",
       "#/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform: "
       "found "
       "\"Not an object\", allowed: an object"},
      {"glTF2/wrongTypes/badNumber.gltf", "#/materials/0/normalTexture: \"index\" is missing"},
      {"glTF2/wrongTypes/badString.gltf", "#/scenes/0/name: found 42, allowed: a string"},
      {"glTF2/wrongTypes/badUint.gltf",
       "#/materials/0/pbrMetallicRoughness/baseColorTexture/index: found -1, allowed: the index"},
      {"glTF2/wrongTypes/badObject.gltf",
       "#/materials/0/pbrMetallicRoughness: found an array of 1, allowed: an object"},
  };
  return kBroken;
}

TEST(GltfModels, EachLoadsOrNamesItsDefect) {
  if (!fs::exists(kModels)) GTEST_SKIP() << "assimp-testmodels is not installed";
  int models = 0, loaded = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kModels)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".gltf" && extension != ".glb") continue;
    ++models;
    const std::string name = entry.path().lexically_relative(kModels).string();
    auto reader = AssetReader::open(kModels.string());
    auto scene = load_gltf(*reader, name);
    const auto defect = broken().find(name);
    if (defect == broken().end()) {
      EXPECT_TRUE(scene.ok()) << scene.status();
      if (!scene.ok()) continue;
      EXPECT_TRUE(Scene::build(*std::move(scene)).ok()) << name;
      ++loaded;
    } else {
      ASSERT_FALSE(scene.ok()) << name;
      EXPECT_THAT(testing::message_of(scene.status()), HasSubstr(name + defect->second));
    }
  }
  EXPECT_GE(models, 40);
  EXPECT_GE(loaded, 25);
}

}  // namespace
}  // namespace lucerna

// Loading any broken file ends with a scene or with a printable error.
#include <gtest/gtest.h>

#include <random>

#include "gltf_fixture.h"
#include "server/formats/printable.h"
#include "tests/mutated.h"

namespace lucerna {
namespace {

using testing::GltfFile;
using testing::GltfFiles;
using testing::Json;
using testing::message_of;
using testing::mutated;

/// A file with nearly everything that the loader reads.
GltfFile everything() {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["indices"] = file.add(std::vector<std::uint16_t>{0, 1, 2}, "SCALAR", 5123);
  primitive["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  primitive["attributes"]["JOINTS_0"] =
      file.add(std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 5121);
  primitive["attributes"]["WEIGHTS_0"] =
      file.add_floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0}, "VEC4");
  primitive["targets"] =
      Json::array({{{"POSITION", file.add_floats({0, 0, 0, 0, 0, 4, 0, 0, 0}, "VEC3")}}});
  primitive["material"] = 0;
  const int indices = file.add_view(testing::bytes_of(std::vector<std::uint8_t>{1}));
  const int values = file.add_view(testing::bytes_of(std::vector<float>{5, 6, 7}));
  file.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
      {"values", {{"bufferView", values}}}};
  file.json["materials"] = Json::array({{{"emissiveFactor", {1, 1, 1}}, {"doubleSided", true}}});
  const int mesh = file.add_mesh(primitive);
  file.json["meshes"][0]["weights"] = {0.5};
  file.json["skins"] = Json::array({{{"joints", {1, 2}}}});
  file.json["cameras"] =
      Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}});
  file.add_node({{"mesh", mesh}, {"scale", {1, 2, -1}}});
  file.add_node({{"translation", {10, 0, 0}}, {"camera", 0}});
  file.add_node({{"rotation", {0, 0, 0, 1}}});
  file.add_node({{"mesh", mesh}, {"skin", 0}});
  file.add_node(
      {{"mesh", mesh},
       {"extensions",
        {{"EXT_mesh_gpu_instancing",
          {{"attributes", {{"TRANSLATION", file.add_floats({1, 0, 0, 2, 0, 0}, "VEC3")}}}}}}}});
  file.add_node(GltfFile::light_node(
      file.add_light({{"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}, {"range", 3}})));
  file.json["animations"] = Json::array(
      {{{"samplers", Json::array({{{"input", file.add_floats({0, 1}, "SCALAR")},
                                   {"output", file.add_floats({0, 0, 0, 1, 0, 0}, "VEC3")}}})},
        {"channels",
         Json::array({{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}})}}});
  return file;
}

constexpr const char* kWords[] = {"\"", "[",    "]",  "{",  "}",          "-",   "1e308", ",",
                                  ":",  "null", "-1", "\\", "4294967295", "0.5", "\xff",  "true"};

/// All values of a JSON text.
void collect(Json& value, std::vector<Json*>& all) {
  all.push_back(&value);
  for (Json& part : value)
    if (value.is_structured()) collect(part, all);
}

/// Replaces one value by another, so that the text stays valid JSON.
void mutate_value(Json& json, std::mt19937& random) {
  static const std::vector<Json> kValues{0,
                                         1,
                                         2,
                                         7,
                                         -1,
                                         1e9,
                                         4294967295U,
                                         0.5,
                                         1e308,
                                         "x",
                                         nullptr,
                                         Json::array(),
                                         Json::object(),
                                         {0, 0, 0, 0},
                                         true,
                                         "translation"};
  std::vector<Json*> all;
  collect(json, all);
  Json& place = *all[1 + random() % (all.size() - 1)];
  if (random() % 3 == 0)
    place = *all[random() % all.size()];
  else
    place = kValues[random() % kValues.size()];
}

bool load_and_check(const GltfFiles& files, const std::string& name) {
  const auto scene = files.load(name);
  if (scene.ok()) {
    for (const ShapeDescription& shape : scene->shapes) {
      EXPECT_LT(shape.material, scene->materials.size());
      const TriangleMeshData& mesh = testing::mesh_of(shape);
      for (const std::uint32_t index : mesh.indices) EXPECT_LT(index, mesh.positions.size());
    }
    for (const InstanceDescription& instance : scene->instances)
      EXPECT_LT(instance.object, scene->objects.size());
    for (const Remark& remark : scene->remarks)
      EXPECT_TRUE(is_printable(remark.where.file.str() + remark.what + remark.instead))
          << remark.what;
  } else {
    EXPECT_NE(message_of(scene.status()), "");
    EXPECT_TRUE(is_printable(message_of(scene.status()))) << scene.status();
  }
  return scene.ok();
}

TEST(GltfMutations, TheUnbrokenFileLoads) {
  const SceneDescription scene = everything().scene();
  EXPECT_EQ(scene.shapes.size(), 4U);  // two nodes and two instances, all emissive
  EXPECT_EQ(scene.lights.size(), 1U);
  EXPECT_NE(scene.camera.motion, nullptr);
}

TEST(GltfMutations, OtherValuesEndWithASceneOrAnError) {
  std::mt19937 random(20260125);
  const GltfFiles files;
  int errors = 0;
  const GltfFile whole = everything();
  const Json json = Json::parse(whole.text());
  for (int i = 0; i < 4000; ++i) {
    Json changed = json;
    for (std::size_t edits = 1 + random() % 2; edits > 0; --edits) mutate_value(changed, random);
    files.write("scene.gltf", changed.dump());
    errors += !load_and_check(files, "scene.gltf");
  }
  EXPECT_GT(errors, 1000);
  EXPECT_LT(errors, 3900);
}

TEST(GltfMutations, OtherBytesEndWithASceneOrAnError) {
  std::mt19937 random(20260126);
  const GltfFiles files;
  const std::string text = everything().text("data.bin"), binary = everything().binary();
  int errors = 0;
  for (int i = 0; i < 2000; ++i) {
    files.write("data.bin", mutated(everything().bytes(), random, kWords));
    files.write("scene.gltf", mutated(text, random, kWords));
    files.write("scene.glb", mutated(binary, random, kWords));
    errors += !load_and_check(files, "scene.gltf");
    errors += !load_and_check(files, "scene.glb");
  }
  EXPECT_GT(errors, 1000);
}

}  // namespace
}  // namespace lucerna

// Errors of glTF files: the file, a JSON pointer, the value and what is allowed.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "gltf_fixture.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using testing::Json;
using testing::message_of;
using ::testing::Not;
using ::testing::StartsWith;

std::string error_of_text(const std::string& text, const std::string& name = "scene.gltf") {
  const GltfFiles files;
  files.write(name, text);
  return message_of(files.load(name).status());
}

/// A scene of one triangle with indices.
GltfFile indexed() {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["indices"] = file.add(std::vector<std::uint8_t>{0, 1, 2}, "SCALAR", 5121);
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  return file;
}

/// The error after `pointer` is set to `value`.
std::string error_with(const std::string& pointer, const Json& value) {
  GltfFile file = indexed();
  file.json[Json::json_pointer(pointer)] = value;
  return file.error();
}

TEST(GltfBadFiles, InvalidJsonNamesLineAndColumn) {
  EXPECT_THAT(error_of_text("{\n  \"asset\": }"), StartsWith("scene.gltf:2:12: invalid JSON"));
  EXPECT_THAT(error_of_text(""), StartsWith("scene.gltf:1:1: invalid JSON"));
  EXPECT_THAT(error_of_text("{\"a\": 1e999}"), StartsWith("scene.gltf: invalid JSON"));
  EXPECT_EQ(error_of_text("[]"), "scene.gltf: found an array of 0, allowed: an object");
}

TEST(GltfBadFiles, JsonBombsAreBounded) {
  EXPECT_EQ(error_of_text("{\"extras\":" + std::string(1'000'000, '[')),
            "scene.gltf: JSON text of more than 64 levels");
  std::string many = "{\"extras\":[0";
  for (int i = 0; i < 8'000'000; ++i) many += ",0";
  EXPECT_EQ(error_of_text(many + "]}"), "scene.gltf: JSON text of more than 8000000 values");
}

TEST(GltfBadFiles, OtherVersions) {
  EXPECT_EQ(error_of_text("{}"), "scene.gltf: \"asset\" is missing");
  EXPECT_EQ(error_with("/asset/version", "1.0"),
            "scene.gltf#/asset/version: found \"1.0\", allowed: \"2.0\"");
  EXPECT_EQ(error_with("/asset/minVersion", "2.1"),
            "scene.gltf#/asset/minVersion: found \"2.1\", allowed: \"2.0\"");
}

TEST(GltfBadFiles, WrongTypesAndIndices) {
  EXPECT_EQ(error_with("/nodes/0/mesh", 7),
            "scene.gltf#/nodes/0/mesh: found 7, allowed: the index of a mesh, 0 to 0");
  EXPECT_EQ(
      error_with("/nodes/0/camera", 0),
      "scene.gltf#/nodes/0/camera: found 0, allowed: nothing, because the file has no camera");
  EXPECT_EQ(error_with("/nodes/0/mesh", "x"),
            "scene.gltf#/nodes/0/mesh: found \"x\", allowed: the index of a mesh, 0 to 0");
  EXPECT_EQ(error_with("/nodes", 3), "scene.gltf#/nodes: found 3, allowed: an array");
  EXPECT_EQ(error_with("/nodes/0/translation", {1, 2}),
            "scene.gltf#/nodes/0/translation: found an array of 2, allowed: an array of 3");
  EXPECT_EQ(error_with("/nodes/0/rotation", {0, 0, 0, 0}),
            "scene.gltf#/nodes/0/rotation: found a quaternion of length 0, allowed: a unit "
            "quaternion");
  EXPECT_EQ(error_with("/nodes/0/rotation", {0, 0, 0.6, 0.9}),
            "scene.gltf#/nodes/0/rotation: found a quaternion of length 1.08167, allowed: a unit "
            "quaternion");
  EXPECT_EQ(error_with("/extensions", {{"KHR_lights_punctual", {{"lights", 5}}}}),
            "scene.gltf#/extensions/KHR_lights_punctual/lights: found 5, allowed: an array");
  EXPECT_EQ(error_with("/extensions", {{"EXT_lights_ies", {{"lights", {1, 2}}}}}),
            "scene.gltf#/extensions/EXT_lights_ies/lights/0: found 1, allowed: an object");
  EXPECT_EQ(
      error_with("/extensions",
                 {{"EXT_lights_image_based", {{"lights", {{{"rotation", {0, 0, 0, 2}}}}}}}}),
      "scene.gltf#/extensions/EXT_lights_image_based/lights/0/rotation: found a quaternion of "
      "length 2, allowed: a unit quaternion");
  EXPECT_EQ(error_with("/accessors/0/componentType", 5124),
            "scene.gltf#/accessors/0/componentType: found 5124, allowed: 5120 to 5123, 5125, 5126");
  EXPECT_EQ(error_with("/accessors/0/count", -1),
            "scene.gltf#/accessors/0/count: found -1, allowed: an integer from 1 to 4294967295");
  EXPECT_EQ(error_with("/meshes/0/primitives/0/mode", 7),
            "scene.gltf#/meshes/0/primitives/0/mode: found 7, allowed: an integer from 0 to 6");
  EXPECT_EQ(error_with("/bufferViews/0/byteStride", 6),
            "scene.gltf#/bufferViews/0/byteStride: found 6, allowed: a multiple of 4");
}

TEST(GltfBadFiles, IndicesOutOfRange) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["indices"] = file.add(std::vector<std::uint8_t>{0, 1, 3}, "SCALAR", 5121);
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  EXPECT_EQ(file.error(),
            "scene.gltf#/meshes/0/primitives/0/indices: index 2 names vertex 3, but "
            "there are 3 vertices");
}

TEST(GltfBadFiles, BuffersTooShort) {
  EXPECT_EQ(
      error_with("/accessors/0/count", 4),
      "scene.gltf#/accessors/0: 4 elements of 12 bytes from byte 0 on, but /bufferViews/0 has "
      "36 bytes");
  EXPECT_EQ(error_with("/bufferViews/0/byteLength", 1000),
            "scene.gltf#/bufferViews/0: bytes 0 to 1000 of buffer 0, which has 40 bytes (named by "
            "/accessors/0)");
  GltfFile file = indexed();
  const GltfFiles files;
  files.write("scene.gltf", file.text("short.bin"));
  files.write("short.bin", file.bytes().substr(0, 20));
  EXPECT_EQ(message_of(files.load("scene.gltf").status()),
            "scene.gltf#/buffers/0/byteLength: found 40, but the buffer has 20 bytes");
}

TEST(GltfBadFiles, MissingAndForbiddenFiles) {
  GltfFile file = indexed();
  const auto error = [&](const std::string& uri) { return error_of_text(file.text(uri)); };
  EXPECT_THAT(error("none.bin"), StartsWith("scene.gltf#/buffers/0/uri: "));
  EXPECT_THAT(error("none.bin"), HasSubstr("none.bin"));
  EXPECT_THAT(error("../secret.bin"), StartsWith("scene.gltf#/buffers/0/uri: "));
  EXPECT_THAT(error("https://example.org/a.bin"), HasSubstr("allowed: a relative path"));
  EXPECT_THAT(error("data:;base64,???"), HasSubstr("invalid base64"));
  EXPECT_THAT(error("data:text/plain"), HasSubstr("a data URI without data"));
  EXPECT_THAT(error("data:,abc"), HasSubstr("but the buffer has 3 bytes"));
}

TEST(GltfBadFiles, CyclesAndSharedNodes) {
  GltfFile file;
  file.json["nodes"] = Json::array({{{"children", {1}}}, {{"children", {0}}}});
  EXPECT_EQ(file.error(), "scene.gltf#/nodes/0: node 0 is beneath itself, allowed: trees");
  file.json["nodes"] = Json::array({{{"children", {0}}}});
  EXPECT_EQ(file.error(), "scene.gltf#/nodes/0: node 0 is beneath itself, allowed: trees");
  file.json["nodes"] = Json::array({{{"children", {2}}}, {{"children", {2}}}, Json::object()});
  EXPECT_EQ(file.error(),
            "scene.gltf#/nodes/1/children/0: node 2 has two parents, nodes 0 and 1, allowed: one; "
            "nodes form trees");
  file.json["nodes"] = Json::array({{{"children", {1}}}, Json::object()});
  file.json["scenes"] = Json::array({{{"nodes", {1}}}});
  EXPECT_EQ(file.error(),
            "scene.gltf#/scenes/0/nodes/0: node 1 has the parent 0, allowed: nodes "
            "without a parent");
}

TEST(GltfBadFiles, DeepTreesLoad) {
  GltfFile file;
  for (int i = 0; i + 1 < 100'000; ++i) file.json["nodes"].push_back({{"children", {i + 1}}});
  file.json["nodes"].push_back(Json::object());
  file.json["scenes"] = Json::array({{{"nodes", {0}}}});
  EXPECT_EQ(file.error(), "");
}

TEST(GltfBadFiles, DeepTreesOfMovingNodesAreBounded) {
  GltfFile file;
  const int moved = file.add_floats({0, 0, 0, 1, 0, 0}, "VEC3");
  Json samplers = Json::array(), channels = Json::array();
  constexpr int kNodes = 2000;
  for (int i = 0; i < kNodes; ++i) {
    file.json["nodes"].push_back(i + 1 < kNodes ? Json{{"children", {i + 1}}}
                                                : GltfFile::light_node(0));
    // Each node has its own key frames.
    samplers.push_back(
        {{"input", file.add_floats({0, 1 + 1e-3F * float(i)}, "SCALAR")}, {"output", moved}});
    channels.push_back({{"sampler", i}, {"target", {{"node", i}, {"path", "translation"}}}});
  }
  file.add_light({{"type", "point"}});
  file.json["scenes"] = Json::array({{{"nodes", {0}}}});
  file.json["animations"] = Json::array({{{"samplers", samplers}, {"channels", channels}}});
  const absl::Status status = file.load().status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(message_of(status), HasSubstr("nodes above each other"));
}

TEST(GltfBadFiles, NumbersThatAreNotFinite) {
  GltfFile file;
  const float infinite = std::numeric_limits<float>::infinity();
  file.add_node(
      {{"mesh", file.add_mesh({{"attributes",
                                {{"POSITION", file.add_floats({0, 0, 0, 1, infinite, 0, 0, 1, 0},
                                                              "VEC3")}}}})}});
  EXPECT_EQ(file.error(), "scene.gltf#/accessors/0: element 1 has the value inf, allowed: finite");
}

TEST(GltfBadFiles, SparseIndicesOutOfRange) {
  GltfFile file = indexed();
  const int indices = file.add_view(testing::bytes_of(std::vector<std::uint8_t>{3}));
  const int values = file.add_view(testing::bytes_of(std::vector<float>{5, 6, 7}));
  file.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_EQ(file.error(), "scene.gltf#/accessors/0/sparse/indices: index 0 is 3, allowed: 0 to 2");
}

TEST(GltfBadFiles, AttributesOfDifferentLengths) {
  GltfFile file = indexed();
  file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.add_floats({0, 0, 1, 0, 0, 1}, "VEC3");
  EXPECT_EQ(file.error(),
            "scene.gltf#/meshes/0/primitives/0/attributes/NORMAL: found 2 elements, "
            "but there are 3 vertices");
}

// Nothing in the file limits the count of elements without bytes.
TEST(GltfBadFiles, ElementsWithoutBytesAreBounded) {
  GltfFile file;
  file.json["accessors"] =
      Json::array({{{"componentType", 5126}, {"count", 17'000'000}, {"type", "VEC3"}}});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", 0}}}})}});
  EXPECT_EQ(file.error(),
            "scene.gltf#/accessors/0/count: found 17000000 elements without bytes, "
            "allowed: 16777216");
}

TEST(GltfBadFiles, Lights) {
  const auto error = [](const Json& light) {
    GltfFile file;
    file.add_node(GltfFile::light_node(file.add_light(light)));
    return file.error();
  };
  const std::string at = "scene.gltf#/extensions/KHR_lights_punctual/lights/0";
  EXPECT_EQ(error({{"type", "tube"}}),
            at + "/type: found \"tube\", allowed: point, spot, directional");
  EXPECT_EQ(error({{"type", "point"}, {"intensity", -1}}),
            at + "/intensity: found -1, allowed: a finite number from 0");
  EXPECT_THAT(error({{"type", "point"}, {"intensity", 1e200}}), StartsWith(at + ": intensity"));
  EXPECT_THAT(error({{"type", "spot"}, {"spot", {{"innerConeAngle", -1}}}}),
              StartsWith(at + "/spot/innerConeAngle: found -1"));
  EXPECT_THAT(error({{"type", "spot"}, {"spot", {{"outerConeAngle", 1.6}}}}),
              StartsWith(at + "/spot/outerConeAngle: found 1.6 rad, allowed: 0 to 1.570796"));
  GltfFile file;
  file.add_node(GltfFile::light_node(0));
  EXPECT_EQ(file.error(),
            "scene.gltf#/nodes/0/extensions/KHR_lights_punctual: the file has no "
            "/extensions/KHR_lights_punctual");
}

TEST(GltfBadFiles, Containers) {
  GltfFile file = indexed();
  const std::string whole = file.binary();
  EXPECT_EQ(error_of_text("glTF", "a.glb"), "a.glb: the file ends within its header of 20 bytes");
  std::string other = whole;
  other[4] = 1;
  EXPECT_EQ(error_of_text(other, "a.glb"), "a.glb: container version 1, allowed: 2");
  EXPECT_THAT(error_of_text(whole.substr(0, whole.size() - 1), "a.glb"),
              HasSubstr("but the file has"));
  other = whole;
  other[12] = other[13] = other[14] = '\x7f';
  EXPECT_THAT(error_of_text(other, "a.glb"), StartsWith("a.glb: the JSON chunk states"));
}

TEST(GltfBadFiles, IndicesWithoutBytes) {
  GltfFile file = indexed();
  const int indices = file.json["meshes"][0]["primitives"][0]["indices"];
  file.json["accessors"][indices].erase("bufferView");
  EXPECT_EQ(file.error(),
            fmt::format("scene.gltf#/meshes/0/primitives/0/indices: names accessor {}, which has "
                        "no bufferView, allowed: one with a bufferView",
                        indices));
}

TEST(GltfBadFiles, EmissiveMeshesWithoutAreaGiveNoLight) {
  GltfFile file;
  Json primitive = {
      {"attributes", {{"POSITION", file.add_floats({0, 0, 0, 1, 0, 0, 2, 0, 0}, "VEC3")}}},
      {"material", 0}};
  file.json["materials"] = Json::array({{{"emissiveFactor", {1, 1, 1}}}});
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  const auto scene = testing::value_of(file.load());
  EXPECT_FALSE(scene.shapes[0].emission.has_value());
  EXPECT_THAT(testing::gltf_remarks(scene), Not(HasSubstr("area")));
  EXPECT_TRUE(Scene::build(scene).ok());
}

}  // namespace
}  // namespace lucerna

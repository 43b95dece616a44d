// Meshes of glTF files: primitive modes, component types, sparse accessors, buffers.
#include <gmock/gmock.h>

#include "gltf_fixture.h"

namespace lucerna {
namespace {

using ::testing::ElementsAre;
using testing::GltfFile;
using testing::GltfFiles;
using ::testing::HasSubstr;
using testing::Json;
using testing::mesh_of;
using Point = Vec3;

/// The mesh of a scene of one node with this primitive.
TriangleMeshData mesh_with(GltfFile& file, const Json& primitive) {
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  const SceneDescription scene = file.scene();
  EXPECT_EQ(scene.shapes.size(), 1U);
  return scene.shapes.empty() ? TriangleMeshData() : mesh_of(scene.shapes[0]);
}

const std::vector<float> kSquare{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};

TEST(GltfMeshes, ATriangleWithoutIndices) {
  GltfFile file;
  const TriangleMeshData mesh = mesh_with(file, file.triangle());
  EXPECT_THAT(mesh.positions, ElementsAre(Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)));
  EXPECT_THAT(mesh.indices, ElementsAre(0U, 1U, 2U));
  EXPECT_TRUE(mesh.normals.empty());
}

// The specification's rules, applied by hand to four vertices.
TEST(GltfMeshes, StripsAndFansKeepTheirWinding) {
  GltfFile strip;
  EXPECT_THAT(mesh_with(strip, {{"attributes", {{"POSITION", strip.add_floats(kSquare, "VEC3")}}},
                                {"mode", 5}})
                  .indices,
              ElementsAre(0U, 1U, 2U, 1U, 3U, 2U));
  GltfFile fan;
  EXPECT_THAT(
      mesh_with(fan, {{"attributes", {{"POSITION", fan.add_floats(kSquare, "VEC3")}}}, {"mode", 6}})
          .indices,
      ElementsAre(1U, 2U, 0U, 2U, 3U, 0U));
}

TEST(GltfMeshes, PointsAndLinesAreLeftOutWithARemark) {
  for (int mode = 0; mode < 4; ++mode) {
    GltfFile file;
    Json primitive = file.triangle();
    primitive["mode"] = mode;
    file.add_node({{"mesh", file.add_mesh(primitive)}});
    const SceneDescription scene = file.scene();
    EXPECT_TRUE(scene.shapes.empty());
    EXPECT_THAT(testing::gltf_remarks(scene),
                HasSubstr(std::string("scene.gltf#/meshes/0/primitives/0/mode: ") +
                          (mode == 0 ? "points" : "lines") + " are not modelled -> left out"));
  }
}

TEST(GltfMeshes, IndicesOfEachTypeAreTheSame) {
  const auto with = [](auto value, int type) {
    GltfFile file;
    Json primitive = file.triangle();
    primitive["indices"] = file.add(
        std::vector{decltype(value)(2), decltype(value)(0), decltype(value)(1)}, "SCALAR", type);
    return mesh_with(file, primitive).indices;
  };
  EXPECT_THAT(with(std::uint8_t{}, 5121), ElementsAre(2U, 0U, 1U));
  EXPECT_THAT(with(std::uint16_t{}, 5123), ElementsAre(2U, 0U, 1U));
  EXPECT_THAT(with(std::uint32_t{}, 5125), ElementsAre(2U, 0U, 1U));
}

template <typename T>
TriangleMeshData with_positions(const std::vector<T>& values, int type, bool normalized) {
  GltfFile file;
  return mesh_with(file,
                   {{"attributes", {{"POSITION", file.add(values, "VEC3", type, normalized)}}}});
}

// KHR_mesh_quantization: c / 127 and so on for normalised integers, else the integer itself.
TEST(GltfMeshes, QuantizedPositionsOfEachType) {
  const std::vector<std::int8_t> small{-128, -127, 0, 127, 0, 0, 0, 1, 0};
  EXPECT_EQ(with_positions(small, 5120, false).positions[0], Point(-128, -127, 0));
  EXPECT_EQ(with_positions(small, 5120, true).positions[0], Point(-1, -1, 0));
  const std::vector<std::uint8_t> bytes{255, 51, 0, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(with_positions(bytes, 5121, false).positions[0], Point(255, 51, 0));
  EXPECT_EQ(with_positions(bytes, 5121, true).positions[0], Point(1, 0.2, 0));
  const std::vector<std::int16_t> shorts{-32768, 32767, 0, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(with_positions(shorts, 5122, true).positions[0], Point(-1, 1, 0));
  const std::vector<std::uint16_t> words{65535, 13107, 0, 0, 0, 0, 0, 1, 0};
  EXPECT_EQ(with_positions(words, 5123, true).positions[0], Point(1, 0.2, 0));
  EXPECT_EQ(with_positions(words, 5123, false).positions[0], Point(65535, 13107, 0));
}

TEST(GltfMeshes, InterleavedAttributesHaveAStride) {
  GltfFile file;
  // Position and normal of each vertex.
  const int view = file.add_view(
      testing::bytes_of(std::vector<float>{0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 2, 0, 1, 0, 0, 0, 2}));
  file.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 24;
  for (const int offset : {0, 12})
    file.json["accessors"].push_back({{"bufferView", view},
                                      {"byteOffset", offset},
                                      {"componentType", 5126},
                                      {"count", 3},
                                      {"type", "VEC3"}});
  const TriangleMeshData mesh = mesh_with(file, {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}});
  EXPECT_THAT(mesh.positions, ElementsAre(Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)));
  ASSERT_EQ(mesh.normals.size(), 3U);
  EXPECT_EQ(mesh.normals[2], Vec3f(0, 0, 1));
}

TEST(GltfMeshes, SparseAccessorsReplaceSomeElements) {
  GltfFile file;
  const Json primitive = file.triangle();
  const int indices = file.add_view(testing::bytes_of(std::vector<std::uint8_t>{1}));
  const int values = file.add_view(testing::bytes_of(std::vector<float>{5, 6, 7}));
  file.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_THAT(mesh_with(file, primitive).positions,
              ElementsAre(Point(0, 0, 0), Point(5, 6, 7), Point(0, 1, 0)));
}

TEST(GltfMeshes, SparseAccessorsWithoutABufferViewStartFromZeros) {
  GltfFile file;
  const Json primitive = file.triangle();
  const int indices = file.add_view(testing::bytes_of(std::vector<std::uint16_t>{1, 2}));
  const int values = file.add_view(testing::bytes_of(std::vector<float>{5, 6, 7, 8, 9, 10}));
  file.json["accessors"][0].erase("bufferView");
  file.json["accessors"][0]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_THAT(mesh_with(file, primitive).positions,
              ElementsAre(Point(0, 0, 0), Point(5, 6, 7), Point(8, 9, 10)));
}

TEST(GltfMeshes, BuffersInAFileInTheTextAndInAContainerAreTheSame) {
  GltfFile file;
  file.add_node({{"mesh", file.add_mesh(file.triangle())}});
  const GltfFiles files;
  files.write("sub/embedded.gltf", file.text());
  files.write("sub/external.gltf", file.text("my%20data.bin"));
  files.write("sub/my data.bin", file.bytes());
  files.write("sub/container.glb", file.binary());
  for (const char* name : {"sub/embedded.gltf", "sub/external.gltf", "sub/container.glb"}) {
    const auto scene = testing::value_of(files.load(name));
    EXPECT_EQ(mesh_of(scene.shapes[0]).positions[1], Point(1, 0, 0)) << name;
  }
  const auto scene = files.load("sub/external.gltf");
  ASSERT_EQ(scene->assets.size(), 2U);
  EXPECT_EQ(scene->assets[1].name, "sub/my data.bin");
}

TEST(GltfMeshes, MorphTargetsAtTheirWeights) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["targets"] =
      Json::array({{{"POSITION", file.add_floats({0, 0, 0, 0, 0, 4, 0, 0, 0}, "VEC3")}},
                   {{"POSITION", file.add_floats({0, 0, 0, 8, 0, 0, 0, 0, 0}, "VEC3")}}});
  const int mesh = file.add_mesh(primitive);
  file.json["meshes"][0]["weights"] = {0.5, 0};
  file.add_node({{"mesh", mesh}});
  file.add_node({{"mesh", mesh}, {"weights", {0, 0.25}}});
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.shapes.size(), 2U);
  // The node's weights replace those of the mesh.
  EXPECT_THAT(
      (std::vector{mesh_of(scene.shapes[0]).positions[1], mesh_of(scene.shapes[1]).positions[1]}),
      ::testing::UnorderedElementsAre(Point(1, 0, 2), Point(3, 0, 0)));
}

TEST(GltfMeshes, SkinsAtRestFollowTheirJoints) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["attributes"]["JOINTS_0"] =
      file.add(std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 5121);
  primitive["attributes"]["WEIGHTS_0"] =
      file.add_floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0}, "VEC4");
  const int mesh = file.add_mesh(primitive);
  const int first = file.add_node({{"translation", {10, 0, 0}}});
  const int second = file.add_node({{"translation", {0, 20, 0}}});
  // The inverse of the second joint's bind pose moves by -5 along y.
  std::vector<float> inverse{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                             1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -5, 0, 1};
  file.json["skins"] = Json::array(
      {{{"joints", {first, second}}, {"inverseBindMatrices", file.add_floats(inverse, "MAT4")}}});
  file.add_node({{"mesh", mesh}, {"skin", 0}, {"translation", {100, 100, 100}}});
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_THAT(mesh_of(scene.shapes[0]).positions,
              ElementsAre(Point(10, 0, 0), Point(1, 15, 0), Point(5, 8.5, 0)));
  const auto is_of_joints = [](const Remark& r) { return r.what == "an animation of joints"; };
  EXPECT_EQ(std::ranges::count_if(scene.remarks, is_of_joints), 0);
  // The pose of a joint that an animation moves stays, which the scene reports.
  file.json["animations"] = Json::array(
      {{{"samplers", Json::array({{{"input", file.add_floats({0, 1}, "SCALAR")},
                                   {"output", file.add_floats({0, 0, 0, 1, 0, 0}, "VEC3")}}})},
        {"channels", Json::array({{{"sampler", 0},
                                   {"target", {{"node", second}, {"path", "translation"}}}}})}}});
  const SceneDescription animated = file.scene();
  EXPECT_EQ(std::ranges::count_if(animated.remarks, is_of_joints), 1);
}

}  // namespace
}  // namespace lucerna

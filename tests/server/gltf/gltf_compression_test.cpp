// KHR_draco_mesh_compression and EXT_meshopt_compression.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gmock/gmock.h>
#include <meshoptimizer.h>

#include <random>
#include <tuple>
#include <utility>

#include "gltf_fixture.h"
#include "server/gltf/draco_mesh.h"
#include "tests/server/files/limited_pool.h"

namespace lucerna {
namespace {

using testing::bytes_of;
using ::testing::ElementsAre;
using testing::GltfFile;
using ::testing::HasSubstr;
using testing::Json;
using testing::mesh_of;
using ::testing::StartsWith;
using Point = Vec3;

const std::vector<float> kPoints{0, 0, 0, 1, 0, 0, 0, 1, 0};

/// A buffer view with `packed` bytes; its own bytes would be in a second buffer that has none.
int add_meshopt(GltfFile& file, const std::vector<unsigned char>& packed, std::size_t count,
                std::size_t stride, const std::string& mode, const std::string& filter = "NONE") {
  const int view = file.add_view(bytes_of(packed));
  Json& place = file.json["bufferViews"][static_cast<std::size_t>(view)];
  place["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                    {"byteOffset", place["byteOffset"]},
                                                    {"byteLength", packed.size()},
                                                    {"count", count},
                                                    {"byteStride", stride},
                                                    {"mode", mode},
                                                    {"filter", filter}};
  place["byteOffset"] = 0;
  place["byteLength"] = count * stride;
  return view;
}

int add_packed_points(GltfFile& file) {
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(3, 12));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), kPoints.data(), 3, 12));
  const int view = add_meshopt(file, packed, 3, 12, "ATTRIBUTES");
  file.json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  return static_cast<int>(file.json["accessors"].size()) - 1;
}

TEST(GltfMeshopt, VerticesAndIndices) {
  GltfFile file;
  const int points = add_packed_points(file);
  const std::vector<std::uint32_t> indices{0, 1, 2};
  std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(3, 3));
  packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), 3));
  const int view = add_meshopt(file, packed, 3, 4, "TRIANGLES");
  file.json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5125}, {"count", 3}, {"type", "SCALAR"}});
  file.add_node(
      {{"mesh", file.add_mesh({{"attributes", {{"POSITION", points}}}, {"indices", 1}})}});
  file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_THAT(mesh_of(scene.shapes[0]).positions,
              ElementsAre(Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)));
  EXPECT_THAT(mesh_of(scene.shapes[0]).indices, ElementsAre(0U, 1U, 2U));
}

// The exponential filter stores 1.5 as 3 times 2^-1: exponent -1 and mantissa 3.
TEST(GltfMeshopt, TheExponentialFilter) {
  GltfFile file;
  const std::uint32_t one_and_a_half = (std::uint32_t{0xff} << 24) | 3;
  const std::vector<std::uint32_t> points{one_and_a_half, 0, 0, 0, one_and_a_half, 0, 0, 0, 0};
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(3, 12));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), points.data(), 3, 12));
  const int view = add_meshopt(file, packed, 3, 12, "ATTRIBUTES", "EXPONENTIAL");
  file.json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  file.add_node({{"mesh", file.add_mesh({{"attributes", {{"POSITION", 0}}}})}});
  EXPECT_THAT(mesh_of(file.scene().shapes.at(0)).positions,
              ElementsAre(Point(1.5, 0, 0), Point(0, 1.5, 0), Point(0, 0, 0)));
}

TEST(GltfMeshopt, Errors) {
  GltfFile file;
  file.add_node(
      {{"mesh", file.add_mesh({{"attributes", {{"POSITION", add_packed_points(file)}}}})}});
  const std::string at = "scene.gltf#/bufferViews/0/extensions/EXT_meshopt_compression";
  const auto error_with = [&](const std::string& key, const Json& value) {
    GltfFile changed = file;
    changed.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value;
    return changed.error();
  };
  EXPECT_EQ(file.error(), "");
  EXPECT_EQ(error_with("byteLength", 5), at + ": the 5 bytes are not 3 compressed elements");
  EXPECT_THAT(error_with("byteLength", 1000), StartsWith(at + ": bytes 0 to 1000 of buffer 0"));
  EXPECT_THAT(error_with("mode", "LZ"), StartsWith(at + "/mode: found \"LZ\""));
  EXPECT_THAT(error_with("buffer", 3), StartsWith(at + "/buffer: found 3"));
  // A bomb: 1 TB from a few bytes.
  GltfFile bomb = file;
  Json& packed = bomb.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  packed["count"] = 0xffffffffU;
  packed["byteStride"] = 256;
  const absl::Status status = bomb.load().status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(testing::message_of(status), StartsWith(at + ": 4294967295 elements of 256 bytes"));
}

/// A triangle compressed by Draco: (0,0,0), (1,0,0), (0,1,0) with normals +z.
std::vector<char> draco_triangle() {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int normal = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  builder.SetAttributeValuesForFace(position, draco::FaceIndex(0), &kPoints[0], &kPoints[3],
                                    &kPoints[6]);
  const float up[3] = {0, 0, 1};
  builder.SetAttributeValuesForFace(normal, draco::FaceIndex(0), up, up, up);
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

GltfFile draco_file() {
  GltfFile file;
  const int view = file.add_view(bytes_of(draco_triangle()));
  file.json["accessors"] =
      Json::array({{{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
                   {{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
                   {{"componentType", 5123}, {"count", 3}, {"type", "SCALAR"}}});
  file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  file.add_node(
      {{"mesh", file.add_mesh({{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}},
                               {"indices", 2},
                               {"extensions",
                                {{"KHR_draco_mesh_compression",
                                  {{"bufferView", view},
                                   {"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}}}}}})}});
  return file;
}

TEST(GltfDraco, ATriangle) {
  const SceneDescription scene = draco_file().scene();
  ASSERT_EQ(scene.shapes.size(), 1U);
  const TriangleMeshData& mesh = mesh_of(scene.shapes[0]);
  ASSERT_EQ(mesh.indices.size(), 3U);
  EXPECT_EQ(mesh.positions[mesh.indices[0]], Point(0, 0, 0));
  EXPECT_EQ(mesh.positions[mesh.indices[1]], Point(1, 0, 0));
  EXPECT_EQ(mesh.positions[mesh.indices[2]], Point(0, 1, 0));
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_EQ(mesh.normals[0], Vec3f(0, 0, 1));
}

TEST(GltfDraco, Errors) {
  const std::string at = "scene.gltf#/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
  GltfFile file = draco_file();
  Json& packed =
      file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  packed["attributes"]["POSITION"] = 9;
  EXPECT_EQ(file.error(),
            at + "/attributes/POSITION: found 9, which is no attribute of the compressed mesh");
  packed["attributes"]["POSITION"] = 0;
  file.json["bufferViews"][0]["byteLength"] = 20;
  EXPECT_THAT(file.error(), StartsWith(at + ": Draco: "));
}

/// A mesh of one triangle whose header announces other counts.  `method`: 0 sequential, 1
/// edgebreaker.
GltfFile draco_bomb(int method, std::uint32_t faces, std::uint32_t points) {
  std::string bytes("DRACO\2\2\1", 8);
  bytes += static_cast<char>(method);
  bytes += std::string(2, '\0');                // flags
  if (method == 1) bytes += std::string(1, 0);  // the standard traversal
  const auto add = [&](std::uint32_t number) {  // as a varint
    for (; number >= 128; number >>= 7) bytes += static_cast<char>(number | 128);
    bytes += static_cast<char>(number);
  };
  add(method == 0 ? faces : points);
  add(method == 0 ? points : faces);
  bytes += std::string(64, '\0');
  GltfFile file = draco_file();
  const int view = file.add_view(bytes);
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
           ["bufferView"] = view;
  return file;
}

constexpr char kDracoPlace[] =
    "scene.gltf#/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";

absl::Status load_within(const GltfFile& file, MemoryPool& pool) {
  const testing::GltfFiles files;
  files.write("scene.gltf", file.text("scene.bin"));
  files.write("scene.bin", file.bytes());
  auto reader = AssetReader::open(files.path().string());
  LoadBudget budget(&pool);
  return load_gltf(*reader, "scene.gltf", {}, {.budget = &budget}).status();
}

// A hundred bytes announce 1.4 10^9 triangles.
TEST(GltfDraco, AMeshOverTheLimitsIsRefusedByItsHeader) {
  for (const int method : {0, 1}) {
    const absl::Status many = draco_bomb(method, 0x55555555, 1000).load().status();
    EXPECT_EQ(many.code(), absl::StatusCode::kResourceExhausted) << many;
    EXPECT_EQ(testing::message_of(many),
              std::string(kDracoPlace) +
                  ": a compressed mesh of 1431655765 triangles, allowed: 268435456");
  }
  // Below the limit of triangles, over that of bytes: 64 bytes of each triangle.
  const absl::Status large = draco_bomb(1, 200'000'000, 1000).load().status();
  EXPECT_EQ(large.code(), absl::StatusCode::kResourceExhausted) << large;
  EXPECT_EQ(testing::message_of(large),
            std::string(kDracoPlace) +
                ": a compressed mesh needs 12800000000 bytes to unpack, allowed: 8589934592");
}

// The decoder would take 240 MB or more for the triangles, or for the vertices.
TEST(GltfDraco, AMeshOverTheBudgetIsRefusedByItsHeader) {
  for (const auto& [method, faces, points] :
       {std::tuple{0, 10'000'000U, 1000U}, {1, 10'000'000U, 1000U}, {1, 1000U, 10'000'000U}}) {
    testing::LimitedPool pool(50'000'000);
    const absl::Status status = load_within(draco_bomb(method, faces, points), pool);
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(testing::message_of(status), std::string(kDracoPlace) + ": the pool is empty");
  }
}

// The values of points take more than the triangles.  The decoder does not begin to decode them.
TEST(GltfDraco, AttributesOverTheBudgetAreRefusedBeforeTheyAreDecoded) {
  constexpr int kFaces = 40'000;
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(kFaces);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (int f = 0; f < kFaces; ++f) {
    const auto x = static_cast<float>(f);
    const float a[3] = {x, 0, 0}, b[3] = {x, 1, 0}, c[3] = {x, 0, 1};
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(f), a, b, c);
  }
  const auto mesh = builder.Finalize();
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    const auto decode = [&](MemoryPool& pool) {
      const testing::GltfFiles files;
      auto reader = AssetReader::open(files.path().string());
      SceneDescription scene;
      LoadBudget budget(&pool);
      gltf::LoadState context(*reader, scene, {}, "scene.gltf", {.budget = &budget});
      const Json json{{"attributes", Json::object()}};
      try {
        (void)gltf::unpack_draco(gltf::View(context, json, "/here"),
                                 {buffer.data(), buffer.size()});
      } catch (const StatusError& failure) {
        return failure.status();
      }
      return absl::OkStatus();
    };
    const std::uint64_t triangles = method == draco::MESH_SEQUENTIAL_ENCODING
                                        ? std::uint64_t{24} * kFaces
                                        : std::uint64_t{64 + 3 * 32} * kFaces;
    // Three floats, three whole numbers and an index for each point.
    const std::uint64_t points = std::uint64_t{12 + 12 + 4} * 3 * kFaces;
    testing::LimitedPool all;
    EXPECT_EQ(decode(all), absl::OkStatus());
    EXPECT_GE(all.most(), triangles + points);
    EXPECT_EQ(all.taken(), 0U);
    testing::LimitedPool pool(triangles + points / 2);
    EXPECT_EQ(testing::message_of(decode(pool)), "scene.gltf#/here: the pool is empty");
  }
}

// Broken bytes end with a scene or with an error.
TEST(GltfCompression, BrokenBytesEndWithASceneOrAnError) {
  std::mt19937 random(20260127);
  GltfFile meshopt;
  meshopt.add_node(
      {{"mesh", meshopt.add_mesh({{"attributes", {{"POSITION", add_packed_points(meshopt)}}}})}});
  const GltfFile draco = draco_file();
  const testing::GltfFiles files;
  files.write("meshopt.gltf", meshopt.text("meshopt.bin"));
  files.write("draco.gltf", draco.text("draco.bin"));
  int errors = 0;
  for (int i = 0; i < 1500; ++i) {
    for (const auto& [name, whole] :
         {std::pair{"meshopt", &meshopt.bytes()}, std::pair{"draco", &draco.bytes()}}) {
      std::string bytes = *whole;
      for (std::size_t edits = 1 + random() % 3; edits > 0; --edits)
        bytes[random() % bytes.size()] = static_cast<char>(random());
      files.write(std::string(name) + ".bin", bytes);
      const auto scene = files.load(std::string(name) + ".gltf");
      errors += !scene.ok();
      if (!scene.ok()) continue;
      for (const ShapeDescription& shape : scene->shapes)
        for (const std::uint32_t index : mesh_of(shape).indices)
          ASSERT_LT(index, mesh_of(shape).positions.size());
    }
  }
  EXPECT_GT(errors, 500);
}

}  // namespace
}  // namespace lucerna

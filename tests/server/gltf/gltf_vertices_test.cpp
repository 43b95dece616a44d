// Colours and tangents of vertices.
#include <gmock/gmock.h>

#include <limits>
#include <numbers>

#include "gltf_fixture.h"
#include "server/estimate/surface_scattering.h"
#include "server/scene/scene.h"

namespace lucerna {
namespace {

using testing::gltf_remarks;
using testing::GltfFile;
using ::testing::HasSubstr;
using testing::Json;
using ::testing::Not;
using testing::png;

const Json kDiffuse = {
    {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"baseColorFactor", {0.5, 1, 1, 1}}}},
    {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}};

/// A triangle with `attributes` and `material` beneath a node.
GltfFile file_of(const Json& material, GltfFile file, Json attributes, Json node = Json::object()) {
  Json primitive = file.triangle();
  primitive["attributes"].update(attributes);
  primitive["material"] = 0;
  file.json["materials"] = Json::array({material});
  node["mesh"] = file.add_mesh(primitive);
  file.add_node(node);
  return file;
}

std::shared_ptr<const Scene> built(const GltfFile& file) { return *Scene::build(*file.load()); }

SurfaceHit hit_at(const Scene& scene, double x, double y) {
  const Vec3 from = Vec3{x, y, 1} - scene.origin();
  return *scene.closest_hit({Vec3f(from), {0, 0, -1}});
}

Rgb reflectance_at(const Scene& scene, double x, double y) {
  SurfaceHit hit = hit_at(scene, x, y);
  const Vec3 up{0, 0, 1};
  return SurfaceScattering(scene, hit).value(up, up) * std::numbers::pi;
}

TEST(GltfVertexColours, AreLinearFactorsOfTheBaseColour) {
  for (const bool is_short : {false, true}) {
    GltfFile file;
    const int colours = is_short
                            ? file.add(std::vector<std::uint16_t>{65535, 0, 0, 65535, 0, 65535, 0,
                                                                  65535, 0, 0, 65535, 65535},
                                       "VEC4", 5123, true)
                            : file.add_floats({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
    const auto scene = built(file_of(kDiffuse, file, {{"COLOR_0", colours}}));
    const Rgb at = reflectance_at(*scene, 0.25, 0.5);
    EXPECT_NEAR(at.r, 0.5 * 0.25, 1e-6);
    EXPECT_NEAR(at.g, 0.25, 1e-6);
    EXPECT_NEAR(at.b, 0.5, 1e-6);
  }
}

TEST(GltfVertexColours, BelongToTheirMesh) {
  for (const bool is_instanced : {false, true}) {
    GltfFile file;
    const int colours = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    Json plain = file.triangle();
    plain["material"] = 0;
    file.add_node({{"mesh", file.add_mesh(plain)}});
    file = file_of(kDiffuse, file, {{"COLOR_0", colours}}, {{"translation", {2, 0, 0}}});
    if (is_instanced) {
      file.add_node({{"mesh", 1}, {"translation", {4, 0, 0}}});
      file.add_node({{"mesh", 0}, {"translation", {6, 0, 0}}});
    }
    const auto scene = built(file);
    for (double x = 0.25; x < (is_instanced ? 8 : 4); x += 2) {
      const bool is_coloured = x > 2 && x < 6;
      const Rgb at = reflectance_at(*scene, x, 0.25);
      EXPECT_NEAR(at.g, is_coloured ? 0 : 1, 1e-6) << x;
      EXPECT_NEAR(at.b, 1, 1e-6) << x;
    }
  }
}

TEST(GltfVertexColours, BadOnesAreErrors) {
  const auto error = [](const std::vector<float>& values, const std::string& type) {
    GltfFile file;
    const int colours = file.add_floats(values, type);
    return file_of(kDiffuse, file, {{"COLOR_0", colours}}).error();
  };
  const std::string at = "scene.gltf#/meshes/0/primitives/0/attributes/COLOR_0: ";
  EXPECT_EQ(error({0, 0, 0, 0, 0, 0}, "VEC2"), at + "found 2 components, allowed: 3 or 4");
  EXPECT_EQ(error({0, 0, 0, 0, 0, 0}, "VEC3"), at + "found 2 elements, but there are 3 vertices");
  EXPECT_EQ(error({0, 0, 0, 0, 0, 0, 0, 1.5F, 0}, "VEC3"),
            at + "element 2 has the value 1.5, allowed: 0 to 1");
}

TEST(GltfVertexColours, AlphaIsReportedWhereItMatters) {
  for (const std::string mode : {"OPAQUE", "BLEND"}) {
    GltfFile file;
    const int colours = file.add_floats({1, 1, 1, 0.5F, 1, 1, 1, 1, 1, 1, 1, 1}, "VEC4");
    Json material = kDiffuse;
    material["alphaMode"] = mode;
    material["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.5};
    const auto scene = testing::value_of(file_of(material, file, {{"COLOR_0", colours}}).load());
    if (mode == "OPAQUE")
      EXPECT_THAT(gltf_remarks(scene), Not(HasSubstr("alpha of vertex colours")));
    else
      EXPECT_THAT(gltf_remarks(scene), HasSubstr("the alpha of vertex colours is not modelled"));
  }
}

/// A triangle whose normal map tilts the normal towards +x and +y of its frame: (0.6, 0.48, 0.64).
GltfFile tilted(const std::vector<float>& uv, const std::vector<float>& tangent, Json node) {
  GltfFile file;
  const std::uint8_t x = 204, y = 189, z = 209;
  file.json["images"] = Json::array(
      {{{"bufferView", file.add_view(png(1, 1, {x, y, z, 255}))}, {"mimeType", "image/png"}}});
  file.json["textures"] = Json::array({{{"source", 0}}});
  Json attributes = {{"TEXCOORD_0", file.add_floats(uv, "VEC2")}};
  if (!tangent.empty()) {
    attributes["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    std::vector<float> all;
    for (int i = 0; i < 3; ++i) all.insert(all.end(), tangent.begin(), tangent.end());
    attributes["TANGENT"] = file.add_floats(all, "VEC4");
  }
  return file_of({{"normalTexture", {{"index", 0}}}}, std::move(file), attributes, std::move(node));
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(GltfVertices, NormalsAndTexturesWithoutANumberAreMended) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, kNan, 0, 1, 0, 0, kNan}, "VEC3");
  file.add_node({{"mesh", file.add_mesh(primitive)}});
  const SceneDescription scene = file.scene();
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("/attributes/NORMAL: 2 of 3 normals have no direction "
                                             "-> the mean of the faces around each"));
  for (const auto& normal : testing::mesh_of(scene.shapes.at(0)).normals)
    EXPECT_EQ(normal, Vec3f(0, 0, 1));
  const GltfFile textured = tilted({0, 1, kNan, 1, 0, 0}, {}, Json::object());
  EXPECT_THAT(gltf_remarks(textured.scene()),
              HasSubstr("/attributes/TEXCOORD_0: the (u, v) of 1 vertices are not finite -> (u, v) "
                        "0, 0"));
}

TEST(GltfVertices, TangentsWithoutANumberLeaveTheFrameToTheCoordinates) {
  const GltfFile file = tilted({0, 1, 1, 1, 0, 0}, {kNan, 1, 0, 1}, Json::object());
  EXPECT_THAT(
      gltf_remarks(file.scene()),
      HasSubstr("/attributes/TANGENT: 3 of 3 tangents have no direction -> the frame follows "
                "the other tangents, or (u, v)"));
  const auto scene = built(file);
  SurfaceHit hit = hit_at(*scene, 0.25, 0.25);
  const SurfaceScattering scattering(*scene, hit);
  EXPECT_LT(length(hit.ns - Vec3{0.6, 0.48, 0.64}), 0.01);
}

struct TiltedCase {
  const char* name;
  std::vector<float> uv;       ///< v downwards, as in the file
  std::vector<float> tangent;  ///< empty: none
  Json node;
  double x, y;  ///< a point on the triangle
  Vec3 normal;  ///< expected
};

TEST(GltfTangents, TurnTheFrameOfNormalMaps) {
  // The picture lies upright, turned, and mirrored; and each of these by a tangent instead.
  const std::vector<float> upright{0, 1, 1, 1, 0, 0}, turned{0, 1, 0, 2, 1, 1},
      mirrored{0, 1, -1, 1, 0, 0};
  const Json still = Json::object(), mirror = {{"scale", {-1, 1, 1}}},
             turn = {{"rotation", {0, 0, 0.70710678, 0.70710678}}};
  const double s = 0.25;
  const TiltedCase cases[] = {
      {"upright", upright, {}, still, s, s, {0.6, 0.48, 0.64}},
      {"turned", turned, {}, still, s, s, {-0.48, 0.6, 0.64}},
      {"mirrored", mirrored, {}, still, s, s, {-0.6, 0.48, 0.64}},
      {"tangent along y", upright, {0, 1, 0, 1}, still, s, s, {-0.48, 0.6, 0.64}},
      {"tangent along -x, mirrored", upright, {-1, 0, 0, -1}, still, s, s, {-0.6, 0.48, 0.64}},
      {"mirrored node", upright, {}, mirror, -s, s, {-0.6, 0.48, 0.64}},
      {"mirrored node, tangent along y", upright, {0, 1, 0, 1}, mirror, -s, s, {0.48, 0.6, 0.64}},
      {"turned node", upright, {}, turn, -s, s, {-0.48, 0.6, 0.64}},
      {"turned node, tangent along y", upright, {0, 1, 0, 1}, turn, -s, s, {-0.6, -0.48, 0.64}},
  };
  for (const TiltedCase& c : cases)
    for (const bool is_instanced : {false, true}) {
      GltfFile file = tilted(c.uv, c.tangent, c.node);
      if (is_instanced) {
        Json other = c.node;
        other["mesh"] = 0;
        other["translation"] = {0, 0, -5};
        file.add_node(other);
      }
      const auto scene = built(file);
      SurfaceHit hit = hit_at(*scene, c.x, c.y);
      const SurfaceScattering scattering(*scene, hit);
      EXPECT_LT(length(hit.ns - c.normal), 0.01)
          << c.name << (is_instanced ? ", instanced: " : ": ") << hit.ns.x << " " << hit.ns.y << " "
          << hit.ns.z;
    }
}

}  // namespace
}  // namespace lucerna

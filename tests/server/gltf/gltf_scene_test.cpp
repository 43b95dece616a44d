// Nodes, instances, cameras, lights and emission of glTF files.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "gltf_fixture.h"

namespace lucerna {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::gltf_remarks;
using testing::GltfFile;
using ::testing::HasSubstr;
using testing::Json;
using testing::mesh_of;
using Point = Vec3;

constexpr double kHalf = std::numbers::sqrt2 / 2;

void expect_near(const Point& a, const Point& b) {
  EXPECT_NEAR(a.x, b.x, 1e-9);
  EXPECT_NEAR(a.y, b.y, 1e-9);
  EXPECT_NEAR(a.z, b.z, 1e-9);
}

Point outside_of(const TriangleMeshData& mesh) {
  const auto p = [&](std::size_t i) { return mesh.positions[mesh.indices[i]]; };
  return normalized(cross(p(1) - p(0), p(2) - p(0)));
}

TEST(GltfNodes, PartsAndTheirMatrixGiveTheSamePlace) {
  GltfFile file;
  const int mesh = file.add_mesh(file.triangle());
  // Scale by (2, 3, 4), turn by 90 degrees about z, move by (5, 6, 7).
  file.add_node({{"mesh", mesh},
                 {"translation", {5, 6, 7}},
                 {"rotation", {0, 0, kHalf, kHalf}},
                 {"scale", {2, 3, 4}}});
  GltfFile other;
  other.add_mesh(other.triangle());
  other.add_node({{"mesh", 0}, {"matrix", {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 5, 6, 7, 1}}});
  const SceneDescription parts = file.scene(), matrix = other.scene();
  const Point expected[] = {{5, 6, 7}, {5, 8, 7}, {2, 6, 7}};
  for (std::size_t i = 0; i < 3; ++i) {
    expect_near(mesh_of(parts.shapes.at(0)).positions[i], expected[i]);
    expect_near(mesh_of(matrix.shapes.at(0)).positions[i], expected[i]);
  }
}

TEST(GltfNodes, ChildrenMoveWithTheirParents) {
  GltfFile file;
  const int mesh = file.add_mesh(file.triangle());
  file.add_node({{"scale", {2, 2, 2}}, {"children", {1}}});
  file.json["nodes"].push_back({{"mesh", mesh}, {"translation", {10, 0, 0}}});
  EXPECT_EQ(mesh_of(file.scene().shapes.at(0)).positions[1], Point(22, 0, 0));
}

TEST(GltfNodes, AMirrorKeepsTheOutside) {
  GltfFile file;
  file.add_node({{"mesh", file.add_mesh(file.triangle())}, {"scale", {-1, 1, 1}}});
  EXPECT_EQ(outside_of(mesh_of(file.scene().shapes.at(0))), Point(0, 0, 1));
}

TEST(GltfNodes, AScaleOfZeroHidesAMesh) {
  GltfFile file;
  file.add_node({{"mesh", file.add_mesh(file.triangle())}, {"scale", {0, 0, 0}}});
  const SceneDescription scene = file.scene();
  EXPECT_TRUE(scene.shapes.empty());
  EXPECT_THAT(gltf_remarks(scene),
              HasSubstr("scene.gltf#/nodes/0: a transform without an inverse"));
}

TEST(GltfNodes, OnlyTheDefaultSceneIsLoaded) {
  GltfFile file;
  const int mesh = file.add_mesh(file.triangle());
  file.json["nodes"] =
      Json::array({{{"mesh", mesh}}, {{"mesh", mesh}, {"translation", {0, 0, 5}}}});
  file.json["scenes"] = Json::array({{{"nodes", {0}}}, {{"nodes", {1}}}});
  file.json["scene"] = 1;
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_EQ(mesh_of(scene.shapes[0]).positions[0], Point(0, 0, 5));
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("2 scenes -> only scene 1 is loaded"));
}

TEST(GltfNodes, AMeshInSeveralPlacesIsOneObject) {
  GltfFile file;
  const int mesh = file.add_mesh(file.triangle());
  for (const int x : {0, 1, 2}) file.add_node({{"mesh", mesh}, {"translation", {x, 0, 0}}});
  const SceneDescription scene = file.scene();
  EXPECT_TRUE(scene.shapes.empty());
  ASSERT_EQ(scene.objects.size(), 1U);
  ASSERT_EQ(scene.instances.size(), 3U);
  EXPECT_EQ(scene.instances[2].world_from_object.point({}), Point(2, 0, 0));
  EXPECT_EQ(scene.instances[2].where.file, "scene.gltf#/nodes/2");
}

TEST(GltfNodes, GpuInstancingPlacesAMesh) {
  GltfFile file;
  const int mesh = file.add_mesh(file.triangle());
  const int translation = file.add_floats({1, 0, 0, 2, 0, 0}, "VEC3");
  const int rotation =
      file.add(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 32767, 0}, "VEC4", 5122, true);
  const int scale = file.add_floats({1, 1, 1, 3, 3, 3}, "VEC3");
  file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  file.add_node(
      {{"mesh", mesh},
       {"translation", {0, 10, 0}},
       {"extensions",
        {{"EXT_mesh_gpu_instancing",
          {{"attributes",
            {{"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}}}}}}}});
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.instances.size(), 2U);
  EXPECT_EQ(scene.instances[0].world_from_object.point({1, 0, 0}), Point(2, 10, 0));
  // Three times as large, and turned by half a turn about z.
  EXPECT_EQ(scene.instances[1].world_from_object.point({1, 0, 0}), Point(-1, 10, 0));
}

TEST(GltfCameras, LookAlongMinusZ) {
  GltfFile file;
  file.json["cameras"] = Json::array(
      {{{"type", "perspective"},
        {"perspective", {{"yfov", std::numbers::pi / 2}, {"aspectRatio", 2}, {"znear", 0.1}}}}});
  // Turned by 90 degrees about y, -z becomes -x.  The scale has no effect.
  file.add_node({{"camera", 0},
                 {"translation", {1, 2, 3}},
                 {"rotation", {0, kHalf, 0, kHalf}},
                 {"scale", {2, 2, 2}}});
  const SceneDescription scene = file.scene();
  const Transform& camera = scene.camera.world_from_camera;
  expect_near(camera.point({0, 0, 0}), {1, 2, 3});
  expect_near(camera.vector({0, 0, 1}), {-1, 0, 0});  // forward
  expect_near(camera.vector({0, 1, 0}), {0, 1, 0});   // up
  expect_near(camera.vector({1, 0, 0}), {0, 0, -1});  // right
  EXPECT_NEAR(scene.camera.screen_max.y, 1, 1e-12);
  EXPECT_NEAR(scene.camera.screen_max.x, 2, 1e-12);
  EXPECT_NEAR(scene.camera.screen_min.x, -2, 1e-12);
  EXPECT_EQ(scene.film.width, 2 * scene.film.height);
}

TEST(GltfCameras, OthersGetARemark) {
  GltfFile file;
  EXPECT_THAT(gltf_remarks(file.scene()), HasSubstr("the scene has no camera"));
  file.json["cameras"] =
      Json::array({{{"type", "orthographic"},
                    {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 9}}}}});
  file.add_node({{"camera", 0}});
  file.add_node({{"camera", 0}});
  const std::string remarks = gltf_remarks(file.scene());
  EXPECT_THAT(remarks, HasSubstr("#/nodes/1/camera: a second camera"));
  EXPECT_THAT(remarks, Not(HasSubstr("orthographic")));
}

TEST(GltfCameras, OrthographicOnesKeepTheirSize) {
  GltfFile file;
  file.json["cameras"] =
      Json::array({{{"type", "orthographic"},
                    {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0}, {"zfar", 9}}}}});
  file.add_node({{"camera", 0}});
  const SceneDescription scene = file.scene();
  EXPECT_EQ(scene.camera.projection, Projection::kOrthographic);
  EXPECT_EQ(scene.camera.screen_max, (Vec2{3, 2}));
  EXPECT_EQ(scene.film.width, scene.film.height * 3 / 2);
}

template <typename Params>
Params light_of(const Json& light, const Json& node = Json::object()) {
  GltfFile file;
  Json placed = GltfFile::light_node(file.add_light(light));
  placed.update(node);
  file.add_node(placed);
  const SceneDescription scene = file.scene();
  EXPECT_EQ(scene.lights.size(), 1U);
  return scene.lights.empty() ? Params() : std::get<Params>(scene.lights[0].params);
}

TEST(GltfLights, PointsAreInCandela) {
  const auto light =
      light_of<PointLightParams>({{"type", "point"}, {"intensity", 100}, {"color", {1, 0.5, 0.25}}},
                                 {{"translation", {1, 2, 3}}, {"scale", {9, 9, 9}}});
  EXPECT_EQ(light.intensity_cd, Rgb(100, 50, 25));
  EXPECT_EQ(light.position_m, Point(1, 2, 3));
}

TEST(GltfLights, DirectionalLightsAreInLuxAndShineAlongMinusZ) {
  const auto light =
      light_of<DistantLightParams>({{"type", "directional"}, {"intensity", 5000}},
                                   {{"rotation", {-kHalf, 0, 0, kHalf}}});  // -z becomes -y
  EXPECT_EQ(light.illuminance_lx, Rgb(5000.0));
  expect_near(light.to_light, {0, 1, 0});
}

TEST(GltfLights, SpotsHaveHalfAngles) {
  const auto light = light_of<SpotLightParams>(
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}});
  EXPECT_EQ(light.intensity_cd, Rgb(1.0));
  EXPECT_EQ(light.falloff_start_rad, 0.25);
  EXPECT_EQ(light.profile, SpotProfile::kQuadratic);
  EXPECT_EQ(light.cone_half_angle_rad, 0.5);
  expect_near(light.axis, {0, 0, -1});
  const auto plain = light_of<SpotLightParams>({{"type", "spot"}, {"spot", Json::object()}});
  EXPECT_EQ(plain.falloff_start_rad, 0);
  EXPECT_EQ(plain.cone_half_angle_rad, std::numbers::pi / 4);
}

TEST(GltfLights, ARangeIsReportedAndNotApplied) {
  GltfFile file;
  file.add_node(GltfFile::light_node(file.add_light({{"type", "point"}, {"range", 12}})));
  EXPECT_THAT(
      gltf_remarks(file.scene()),
      HasSubstr("scene.gltf#/extensions/KHR_lights_punctual/lights/0/range: a range of 12 m "
                "is not applied"));
}

TEST(GltfLights, HaveTheNameOfTheirNodeOrElseTheirOwn) {
  GltfFile file;
  const int light = file.add_light({{"type", "point"}, {"name", "bulb"}});
  const std::string long_name(257, 'x');
  for (const char* name : {"", "desk", "a\nb", long_name.c_str()}) {
    Json node = GltfFile::light_node(light);
    if (*name != '\0') node["name"] = name;
    file.add_node(node);
  }
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.lights.size(), 4U);
  EXPECT_EQ(scene.lights[0].name, "bulb");
  EXPECT_EQ(scene.lights[1].name, "desk");
  EXPECT_EQ(scene.lights[2].name, "");
  EXPECT_EQ(scene.lights[3].name, "");
  EXPECT_THAT(gltf_remarks(scene),
              AllOf(HasSubstr("#/nodes/2: the name \"a?b\" of 3 bytes, allowed: 256 bytes without "
                              "control characters -> a light without a name"),
                    HasSubstr("#/nodes/3: the name \"xxx")));
}

TEST(GltfLights, SurfacesThatEmitHaveTheNameOfTheirNodeOrElseOfTheirMesh) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["material"] = 0;
  file.json["materials"] = Json::array({{{"emissiveFactor", {1, 1, 1}}}});
  const int mesh = file.add_mesh(primitive);
  file.json["meshes"][0]["name"] = "tube";
  file.add_node({{"mesh", mesh}});
  file.add_node({{"mesh", mesh}, {"name", "left tube"}});
  const SceneDescription scene = file.scene();
  ASSERT_EQ(scene.shapes.size(), 2U);
  EXPECT_EQ(scene.shapes[0].emission->name, "tube");
  EXPECT_EQ(scene.shapes[1].emission->name, "left tube");
}

/// A scene of an emissive triangle at each x.
SceneDescription emissive(std::vector<int> places, bool double_sided) {
  GltfFile file;
  Json primitive = file.triangle();
  primitive["material"] = 0;
  file.json["materials"] = Json::array(
      {{{"emissiveFactor", {1, 0.5, 0}},
        {"doubleSided", double_sided},
        {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1000}}}}}}});
  const int mesh = file.add_mesh(primitive);
  for (const int x : places) file.add_node({{"mesh", mesh}, {"translation", {x, 0, 0}}});
  return file.scene();
}

TEST(GltfMaterials, EmissionIsFactorTimesStrength) {
  const SceneDescription scene = emissive({0}, false);
  ASSERT_TRUE(scene.shapes.at(0).emission);
  EXPECT_EQ(scene.shapes[0].emission->radiance_cd_m2, Rgb(1000, 500, 0));
  EXPECT_FALSE(scene.shapes[0].emission->two_sided);
  EXPECT_TRUE(emissive({0}, true).shapes.at(0).emission->two_sided);
}

TEST(GltfMaterials, EmissiveMeshesAreCopiedToEachPlace) {
  const SceneDescription scene = emissive({0, 5}, false);
  EXPECT_TRUE(scene.instances.empty());
  ASSERT_EQ(scene.shapes.size(), 2U);
  EXPECT_EQ(mesh_of(scene.shapes[1]).positions[0], Point(5, 0, 0));
  EXPECT_EQ(scene.shapes[1].emission->where.file, "scene.gltf#/nodes/1");
}

TEST(GltfExtensions, RequiredOnesThatAreNotModelledFail) {
  GltfFile file;
  file.json["extensionsUsed"] = {"KHR_unknown"};
  EXPECT_THAT(gltf_remarks(file.scene()),
              HasSubstr("scene.gltf#/extensionsUsed/0: extension \"KHR_unknown\" is not modelled"));
  file.json["extensionsRequired"] = {"KHR_lights_punctual", "KHR_unknown"};
  EXPECT_EQ(file.error(),
            "scene.gltf#/extensionsRequired/1: the file requires the extension \"KHR_unknown\", "
            "which is not modelled");
}

/// The scene of a node whose channel `path` has these key frames.
SceneDescription moving(const std::string& path, const std::vector<float>& times,
                        const std::vector<float>& values, const std::string& interpolation,
                        const Json& child = nullptr) {
  GltfFile file;
  const int mesh = file.add_mesh(file.triangle());
  Json node = {{"mesh", mesh}};
  if (!child.is_null()) node = {{"children", {1}}};
  file.add_node(node);
  if (!child.is_null()) {
    file.json["nodes"].push_back(child);
    file.json["nodes"][1]["mesh"] = mesh;
  }
  file.json["animations"] = Json::array(
      {{{"samplers",
         Json::array({{{"input", file.add_floats(times, "SCALAR")},
                       {"output", file.add_floats(values, path == "rotation" ? "VEC4" : "VEC3")},
                       {"interpolation", interpolation}}})},
        {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}})}}});
  return file.scene();
}

TEST(GltfAnimation, ATranslationIsLinear) {
  const SceneDescription scene = moving("translation", {1, 3}, {0, 0, 0, 8, 0, 0}, "LINEAR");
  const ShapeDescription& shape = scene.shapes.at(0);
  ASSERT_NE(shape.motion, nullptr);
  expect_near(shape.motion->at(0).point({1, 0, 0}), {1, 0, 0});
  expect_near(shape.motion->at(2).point({1, 0, 0}), {5, 0, 0});
  expect_near(shape.motion->at(9).point({1, 0, 0}), {9, 0, 0});
}

TEST(GltfAnimation, AChildTurnsAboutItsParent) {
  const auto h = static_cast<float>(kHalf);
  // Half a turn in two seconds, by two quarters.
  const SceneDescription scene = moving("rotation", {0, 1, 2}, {0, 0, 0, 1, 0, 0, h, h, 0, 0, 1, 0},
                                        "LINEAR", {{"translation", {2, 0, 0}}});
  const ShapeDescription& shape = scene.shapes.at(0);
  ASSERT_NE(shape.motion, nullptr);
  const Point start = mesh_of(shape).positions[0];
  expect_near(start, {2, 0, 0});
  const double r = 2 * kHalf;
  const auto near = [](const Point& a, const Point& b) { EXPECT_LT(length(a - b), 1e-6); };
  near(shape.motion->at(0.5).point(start), {r, r, 0});
  near(shape.motion->at(1).point(start), {0, 2, 0});
  near(shape.motion->at(1.5).point(start), {-r, r, 0});
}

TEST(GltfAnimation, StepsJump) {
  const SceneDescription scene =
      moving("translation", {0, 1, 2}, {0, 0, 0, 4, 0, 0, 8, 0, 0}, "STEP");
  const Motion& motion = *scene.shapes.at(0).motion;
  expect_near(motion.at(0.99).point({}), {0, 0, 0});
  expect_near(motion.at(1).point({}), {4, 0, 0});
  expect_near(motion.at(1.99).point({}), {4, 0, 0});
}

// With tangents of 0 a spline passes half the way at half the time, and 7/64 + ... at a quarter:
// 3 t^2 - 2 t^3 = 0.15625.
TEST(GltfAnimation, SplinesAreCurved) {
  const SceneDescription scene =
      moving("translation", {0, 1}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 64, 0, 0, 0, 0, 0},
             "CUBICSPLINE");
  const Motion& motion = *scene.shapes.at(0).motion;
  expect_near(motion.at(0.25).point({}), {10, 0, 0});
  expect_near(motion.at(0.5).point({}), {32, 0, 0});
}

TEST(GltfAnimation, ScaleIsReported) {
  const SceneDescription scene = moving("scale", {0, 1}, {1, 1, 1, 2, 2, 2}, "LINEAR");
  EXPECT_EQ(scene.shapes.at(0).motion, nullptr);
  EXPECT_THAT(gltf_remarks(scene), HasSubstr("animation of \"scale\" is not modelled"));
}

TEST(GltfAnimation, LightsAndCamerasMoveToo) {
  GltfFile file;
  Json node = GltfFile::light_node(file.add_light({{"type", "point"}}));
  node["camera"] = 0;
  file.json["cameras"] =
      Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}});
  file.add_node(node);
  file.json["animations"] = Json::array(
      {{{"samplers", Json::array({{{"input", file.add_floats({0, 1}, "SCALAR")},
                                   {"output", file.add_floats({0, 0, 0, 1, 0, 0}, "VEC3")}}})},
        {"channels",
         Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}})}}});
  const SceneDescription scene = file.scene();
  EXPECT_NE(scene.lights.at(0).motion, nullptr);
  EXPECT_NE(scene.camera.motion, nullptr);
}

}  // namespace
}  // namespace lucerna

// The reference scenes load with the right contents.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <variant>

#include "pbrt_fixture.h"
#include "tests/paths.h"

namespace lucerna {
namespace {

SceneDescription reference(const std::string& name) {
  auto assets = AssetReader::open(test_data("reference"));
  EXPECT_TRUE(assets.ok());
  auto scene = load_pbrt(*assets, name + ".pbrt");
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *std::move(scene) : SceneDescription();
}

struct Expected {
  const char* name;
  std::size_t shapes, emitters, lights;
  int max_depth, samples;
};

TEST(PbrtReference, ScenesLoadWithoutRemarks) {
  const Expected kScenes[] = {
      {"point", 4, 0, 1, 1, 1024},
      {"point_power", 4, 0, 1, 1, 1024},
      {"spot", 4, 0, 1, 1, 1024},
      {"spot_hard", 4, 0, 1, 1, 1024},
      {"distant", 4, 0, 1, 1, 1024},
      {"triangle", 5, 1, 0, 1, 4096},
      {"rectangle", 5, 1, 0, 1, 4096},
      {"rectangle_near", 5, 1, 0, 1, 4096},
      {"two_sided", 5, 1, 0, 1, 4096},
      {"sphere", 5, 1, 0, 1, 4096},
      {"disk", 5, 1, 0, 1, 4096},
      {"cylinder", 5, 1, 0, 1, 4096},
      {"infinite", 4, 0, 1, 1, 4096},
      {"many_points", 4, 0, 400, 1, 8192},
      {"many_triangles", 154, 150, 0, 1, 8192},
      {"bounces", 11, 1, 0, 6, 8192},
      {"colour", 6, 2, 0, 1, 4096},
  };
  for (const Expected& expected : kScenes) {
    SCOPED_TRACE(expected.name);
    const SceneDescription scene = reference(expected.name);
    EXPECT_EQ(testing::remarks_of(scene), "");
    EXPECT_EQ(scene.shapes.size(), expected.shapes);
    EXPECT_EQ(scene.lights.size(), expected.lights);
    std::size_t emitters = 0;
    for (const ShapeDescription& shape : scene.shapes) emitters += shape.emission.has_value();
    EXPECT_EQ(emitters, expected.emitters);
    EXPECT_EQ(scene.hints.max_depth, expected.max_depth);
    EXPECT_EQ(scene.hints.samples_per_pixel, expected.samples);
    EXPECT_EQ(scene.film.width, 160);
    EXPECT_EQ(scene.film.height, 120);
    EXPECT_EQ(scene.film.scale, 1);
    ASSERT_EQ(scene.assets.size(), 2U);
    EXPECT_EQ(scene.assets[1].name, "ball.ply");
  }
}

TEST(PbrtReference, LightsHaveTheLevelsOfTheFiles) {
  const auto spot = std::get<SpotLightParams>(reference("spot").lights[0].params);
  EXPECT_EQ(spot.intensity_cd, Rgb(40));
  EXPECT_EQ(spot.position_m, Vec3(2, -2.5, 3.5));
  EXPECT_NEAR(spot.falloff_start_rad * 180 / M_PI, 18, 1e-12);
  const auto hard = std::get<SpotLightParams>(reference("spot_hard").lights[0].params);
  EXPECT_EQ(hard.falloff_start_rad, hard.cone_half_angle_rad);
  const auto point = std::get<PointLightParams>(reference("point_power").lights[0].params);
  EXPECT_NEAR(point.intensity_cd.b, 150 / (4 * M_PI), 1e-12);
  const auto distant = std::get<DistantLightParams>(reference("distant").lights[0].params);
  EXPECT_EQ(distant.to_light, Vec3(1.5, -2, 3));
}

TEST(PbrtReference, TheRectangleShinesDownAndTheDiskTowardsTheScene) {
  const SceneDescription rectangle = reference("rectangle");
  const auto& patch = std::get<PatchMeshData>(rectangle.shapes[0].geometry);
  const auto p = [&](int k) { return patch.positions[patch.indices[k]]; };
  EXPECT_LT(cross(p(1) - p(0), p(2) - p(0)).z, 0);
  const auto disk = std::get<DiskParams>(reference("disk").shapes[0].geometry);
  EXPECT_NEAR(disk.world_from_object.normal({0, 0, 1}).z, -0.778971191, 1e-8);
}

TEST(PbrtReference, TheBallIsAClosedSurfaceWithNormalsThatLeaveIt) {
  const SceneDescription scene = reference("point");
  const auto& ball = std::get<TriangleMeshData>(scene.shapes[2].geometry);
  ASSERT_EQ(ball.positions.size(), 2112U);
  ASSERT_EQ(ball.indices.size(), 3 * 3968U);
  double volume = 0;
  Vec3 centre{};
  for (const auto& position : ball.positions) centre += position / 2112.0;
  for (std::size_t i = 0; i < ball.indices.size(); i += 3) {
    const auto p = [&](int k) { return ball.positions[ball.indices[i + k]] - centre; };
    volume += dot(p(0), cross(p(1), p(2))) / 6;
  }
  EXPECT_GT(volume, 0);
  for (std::size_t i = 0; i < ball.positions.size(); ++i)
    EXPECT_GT(dot(Vec3(ball.normals[i]), ball.positions[i] - centre), 0);
}

// Tests of the calls load this scene, so a light or a shape that is missing here is not tested.
TEST(EveryLightScene, HasEveryModelAndEveryShape) {
  auto assets = testing::value_of(AssetReader::open(test_data()));
  const auto scene = testing::value_of(load_pbrt(assets, "lights/every_light.pbrt"));
  std::set<std::size_t> models, shapes;
  for (const LightDescription& light : scene.lights) models.insert(light.params.index());
  for (const ShapeDescription& shape : scene.shapes)
    if (shape.emission) shapes.insert(shape.geometry.index());
  EXPECT_EQ(models.size(), FreeLights::kSize);
  // Curves do not emit.
  EXPECT_EQ(shapes.size(), std::variant_size_v<decltype(ShapeDescription::geometry)> - 1);
}

}  // namespace
}  // namespace lucerna

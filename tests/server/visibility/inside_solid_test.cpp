#include "server/visibility/inside_solid.h"

#include <gtest/gtest.h>

#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;

/// The box between two corners as triangles, normals outwards.  `sides` selects -x, +x, -y, +y, -z,
/// +z.
ShapeDescription box(const Vec3& lower, const Vec3& upper, std::uint32_t sides = 0b111111) {
  TriangleMeshData mesh;
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(
        {i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  constexpr std::uint32_t kCorners[6][6] = {{0, 4, 6, 0, 6, 2}, {1, 3, 7, 1, 7, 5},
                                            {0, 1, 5, 0, 5, 4}, {2, 6, 7, 2, 7, 3},
                                            {0, 2, 3, 0, 3, 1}, {4, 5, 7, 4, 7, 6}};
  for (std::uint32_t side = 0; side < 6; ++side)
    if (sides >> side & 1)
      mesh.indices.insert(mesh.indices.end(), kCorners[side], kCorners[side] + 6);
  return testing::shape(std::move(mesh));
}

constexpr std::uint32_t kNoTop = 0b011111, kNoBottom = 0b101111;

ShapeDescription turned(ShapeDescription shape) {
  auto& mesh = std::get<TriangleMeshData>(shape.geometry);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    std::swap(mesh.indices[i], mesh.indices[i + 1]);
  return shape;
}

std::shared_ptr<const Scene> scene_of(ShapeList shapes, const Vec3& lamp = {0, 0, 2.5}) {
  SceneDescription d = testing::description();
  d.shapes = std::move(shapes);
  d.lights = {testing::point_light(lamp, 100)};
  return build(std::move(d));
}

SurfaceHit receiver(const Vec3& position, const Vec3& normal) {
  SurfaceHit hit;
  hit.position = position;
  hit.position_error = {1e-6F, 1e-6F, 1e-6F};
  hit.ng = hit.ns = normal;
  return hit;
}

bool inside(const Scene& scene, const Vec3& position) {
  return is_inside_solid(scene, receiver(position, {0, 0, 1}));
}

TEST(InsideSolid, APointInAClosedBoxIsFlagged) {
  const auto scene = scene_of({box({-1, -1, 0}, {1, 1, 1})});
  EXPECT_TRUE(inside(*scene, {0, 0, 0.5}));
  EXPECT_TRUE(inside(*scene, {0.9, -0.9, 0.01}));
  EXPECT_FALSE(inside(*scene, {0, 0, 1.5}));
  EXPECT_FALSE(inside(*scene, {1.5, 0, 0.5}));
}

TEST(InsideSolid, APointUnderATableIsNotFlagged) {
  // A board on two legs, one shape each, on the floor.
  const auto scene = scene_of({testing::floor(3), box({-1, -1, 0.7}, {1, 1, 0.75}),
                               box({-1, -1, 0}, {-0.9, 1, 0.7}), box({0.9, -1, 0}, {1, 1, 0.7})});
  EXPECT_FALSE(inside(*scene, {0, 0, 0.3}));
  EXPECT_FALSE(inside(*scene, {0, 0, 0.69}));
  EXPECT_TRUE(inside(*scene, {0, 0, 0.72}));
}

TEST(InsideSolid, APointInAnOpenBoxIsNotFlaggedNorUnderACeiling) {
  EXPECT_FALSE(inside(*scene_of({box({-1, -1, 0}, {1, 1, 1}, kNoTop)}), {0, 0, 0.1}));
  EXPECT_FALSE(inside(
      *scene_of({testing::floor(3), testing::floor(9, 3), box({-1, -1, 0}, {1, 1, 1}, kNoTop)}),
      {0, 0, 0.1}));
}

TEST(InsideSolid, APointJustOffAWallIsNotFlaggedOnEitherSideNorOnIt) {
  const auto scene = scene_of({testing::floor(9), box({2, -3, 0}, {2.2, 3, 3})});
  EXPECT_FALSE(inside(*scene, {1.999, 0, 1}));
  EXPECT_FALSE(inside(*scene, {2.2001, 0, 1}));
  EXPECT_FALSE(inside(*scene, {2, 0, 1}));
  EXPECT_FALSE(inside(*scene, {2 + 1e-7, 0, 1}));
  EXPECT_TRUE(inside(*scene, {2.001, 0, 1}));
}

// Where two surfaces coincide, a ray finds one of them.
TEST(InsideSolid, FurnitureThatTouchesFloorAndWallIsASolid) {
  for (const bool floor_first : {false, true}) {
    ShapeList shapes = {box({-1, -1, 0}, {1, 1, 1})};
    const ShapeList room = {testing::floor(3),
                            testing::patch({-3, -1, 0}, {3, -1, 0}, {-3, -1, 3}, {3, -1, 3})};
    shapes.insert(floor_first ? shapes.begin() : shapes.end(), room.begin(), room.end());
    const auto scene = scene_of(std::move(shapes));
    for (const double z : {0.01, 0.2, 0.5, 0.99}) EXPECT_TRUE(inside(*scene, {0.3, -0.4, z})) << z;
    EXPECT_FALSE(inside(*scene, {0.3, -0.4, 1.01}));
  }
  // Closed only by the floor.
  EXPECT_TRUE(
      inside(*scene_of({testing::floor(3), box({-1, -1, 0}, {1, 1, 1}, kNoBottom)}), {0, 0, 0.5}));
}

TEST(InsideSolid, AReceiverOnASurfaceLooksAtTheSideOfItsNormal) {
  const auto facing = [](const Scene& scene, const Vec3& at, const Vec3& normal) {
    return is_inside_solid(scene, receiver(at, normal));
  };
  // The floor lies at a height whose coordinates round.
  for (const double z : {0.0, 3.3}) {
    for (const bool has_bottom : {true, false}) {
      const auto scene = scene_of({testing::floor(9, z), box({-1, -1, z}, {1, 1, z + 0.7},
                                                             has_bottom ? 0b111111 : kNoBottom)},
                                  {0, 0, z + 2.5});
      EXPECT_TRUE(facing(*scene, {0.2, 0.3, z}, {0, 0, 1})) << z << has_bottom;
      EXPECT_TRUE(facing(*scene, {0.2, 0.3, z}, {0.6, 0, 0.8})) << z << has_bottom;
      EXPECT_FALSE(facing(*scene, {1.5, 0.3, z}, {0, 0, 1})) << z << has_bottom;
      EXPECT_FALSE(facing(*scene, {0.2, 0.3, z + 0.7}, {0, 0, 1})) << z << has_bottom;
      EXPECT_TRUE(facing(*scene, {0.2, 0.3, z + 0.7}, {0, 0, -1})) << z << has_bottom;
    }
    // A board on two legs: the floor between the legs is not inside, that below a leg is.
    const auto table =
        scene_of({testing::floor(9, z), box({-1, -1, z + 0.7}, {1, 1, z + 0.75}),
                  box({-1, -1, z}, {-0.9, 1, z + 0.7}), box({0.9, -1, z}, {1, 1, z + 0.7})},
                 {0, 0, z + 2.5});
    EXPECT_FALSE(facing(*table, {0, 0, z}, {0, 0, 1})) << z;
    EXPECT_TRUE(facing(*table, {-0.95, 0, z}, {0, 0, 1})) << z;
  }
}

TEST(InsideSolid, ARoomIsNotASolidButItsFurnitureIs) {
  for (const bool outwards : {true, false}) {
    const ShapeDescription walls = box({-3, -3, 0}, {3, 3, 3});
    const auto scene = scene_of({outwards ? walls : turned(walls), box({-1, -1, 0}, {1, 1, 1})});
    EXPECT_FALSE(inside(*scene, {2, 2, 0.5})) << outwards;
    EXPECT_TRUE(inside(*scene, {0, 0, 0.5})) << outwards;
  }
}

TEST(InsideSolid, TheLimitsAreAsDocumented) {
  // Normals inwards: not found.  A room without a lamp, normals outwards: found.
  EXPECT_FALSE(inside(*scene_of({turned(box({-1, -1, 0}, {1, 1, 1}))}), {0, 0, 0.5}));
  EXPECT_TRUE(inside(*scene_of({box({-3, -3, 0}, {3, 3, 3})}, {0, 0, 9}), {0, 0, 0.5}));
  // The light of the shape itself does not count as a lamp in a room.
  EXPECT_TRUE(inside(*scene_of({testing::emissive(box({-1, -1, 0}, {1, 1, 1}), 5)}), {0, 0, 0.5}));
}

TEST(InsideSolid, ManyPointsGetTheSameAnswers) {
  const auto scene = scene_of({testing::floor(9), box({-1, -1, 0}, {1, 1, 1})});
  std::vector<SurfaceHit> points;
  for (int i = 0; i < 40; ++i) points.push_back(receiver({-2 + 0.1 * i, 0.05, 0.5}, {0, 0, 1}));
  const auto flags = inside_solids(*scene, points, {});
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(flags[i] != 0, is_inside_solid(*scene, points[i])) << i;
    EXPECT_EQ(flags[i] != 0, i > 10 && i < 30) << i;
  }
}

/// A panel of 0.6 m that shines down, `gap` below a ceiling at 2.8 m.
std::shared_ptr<const Scene> under_a_ceiling(double gap, const ShapeList& more = {}) {
  const double z = 2.8 - gap;
  SceneDescription d = testing::description();
  d.shapes = {
      testing::floor(3, 2.8), testing::floor(3),
      testing::emissive(
          testing::patch({0.3, -0.3, z}, {-0.3, -0.3, z}, {0.3, 0.3, z}, {-0.3, 0.3, z}), 100)};
  d.shapes.insert(d.shapes.end(), more.begin(), more.end());
  return build(std::move(d));
}

bool covered(const Scene& scene, const Vec3& position, double normal_z = -1) {
  return is_inside_solid(scene, receiver(position, {0, 0, normal_z}));
}

TEST(InsideSolid, APointOfTheCeilingAboveAPanelIsFlagged) {
  for (const double gap : {0.0, 1e-7, 1e-3, 0.04}) {
    const auto scene = under_a_ceiling(gap);
    EXPECT_TRUE(covered(*scene, {0.1, 0.1, 2.8})) << gap;
    EXPECT_FALSE(covered(*scene, {0.5, 0.1, 2.8})) << gap;
    // The floor sees the front, and the upper storey sees the ceiling.
    EXPECT_FALSE(covered(*scene, {0.1, 0.1, 0}, 1)) << gap;
    EXPECT_FALSE(covered(*scene, {0.1, 0.1, 2.8}, 1)) << gap;
  }
  EXPECT_FALSE(covered(*under_a_ceiling(0.3), {0.1, 0.1, 2.8}));
}

TEST(InsideSolid, APointOfTheCeilingBehindAPanelWithARimIsFlagged) {
  // Normals that point inwards make no solid of the rim.
  const auto with_rim = [](double gap, std::uint32_t sides) {
    return under_a_ceiling(gap,
                           {turned(box({-0.301, -0.301, 2.8 - gap}, {0.301, 0.301, 2.8}, sides))});
  };
  constexpr std::uint32_t kAround = 0b001111, kThreeSides = 0b001110;
  for (const double gap : {0.06, 0.1, 0.2})
    for (const double x : {0.0, 0.1, 0.25})
      EXPECT_TRUE(covered(*with_rim(gap, kAround), {x, 0.2, 2.8})) << gap << " " << x;
  EXPECT_FALSE(covered(*with_rim(0.2, kThreeSides), {0.1, 0.2, 2.8}));
  EXPECT_FALSE(covered(*with_rim(0.1, kAround), {0.4, 0.1, 2.8}));
  EXPECT_FALSE(covered(*with_rim(0.1, kAround), {0.1, 0.1, 0}, 1));
}

}  // namespace
}  // namespace lucerna

// A shaft that is reported empty is empty: no shadow ray to the light meets anything.
#include "server/visibility/shaft.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "lights/sampling/sampling.h"
#include "server/rays/accelerator.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;
using testing::emissive;
using testing::patch;
using testing::shape;
SurfaceHit receiver_at(const Vec3& position, const Vec3& normal, double error = 1e-7) {
  SurfaceHit hit;
  hit.position = position;
  const auto e = static_cast<float>(error * std::max(1.0, max_abs(position)));
  hit.position_error = {e, e, e};
  hit.ns = hit.ng = normalized(normal);
  return hit;
}

bool is_empty(const Scene& scene, const SurfaceHit& receiver, std::uint32_t light = 0) {
  return Shafts(scene).is_empty(receiver, Vec3f(receiver.ns), light);
}

/// Samples whose light arrives above the receiver's horizon, and the number of their rays that meet
/// something.
struct Rays {
  int lit = 0, blocked = 0;
};

Rays shoot(const Scene& scene, const SurfaceHit& receiver, std::uint32_t light, int count,
           std::mt19937& random) {
  std::uniform_real_distribution<double> u(0, 1);
  Rays rays;
  const SceneLight& l = scene.lights()[light];
  Receiver r(receiver.position);
  r.normal = receiver.ns;
  const Light& model = *l.light;
  for (int i = 0; i < count; ++i) {
    // One of four samples is from the edges of the light.
    const auto value = [&] { return i % 4 == 0 ? std::round(u(random)) : u(random); };
    const auto s = model.sample_li(r, {value(), u(random)});
    if (s.reason != NoLight::kNone || !(dot(r.normal, s.wi) > 0)) continue;
    ++rays.lit;
    // A ray to the very rim of a sphere may meet the sphere itself, which is not an obstacle.
    const auto hit = scene.closest_hit(shadow_ray(receiver, s, l.reach_m()));
    rays.blocked += hit && hit->light != static_cast<std::int32_t>(light) ? 1 : 0;
  }
  return rays;
}

/// The room of side 2 with a lamp of half-side `lamp` under its ceiling.
SceneDescription room_with_lamp(double lamp = 0.25, double below_ceiling = 0) {
  SceneDescription d = testing::description();
  const double s = lamp, z = 1 - below_ceiling;
  d.shapes = {shape(testing::room()),
              emissive(patch({-s, -s, z}, {-s, s, z}, {s, -s, z}, {s, s, z}), 10)};
  return d;
}

TEST(Shaft, FromAFloorToALampInTheCeilingIsEmpty) {
  // In the ceiling's plane, and below it.  The receiver's floor and the walls do not count.
  for (const double below : {0.0, 1e-3, 0.1}) {
    const auto scene = build(room_with_lamp(0.25, below));
    for (const double x : {0.0, 0.5, 0.95})
      EXPECT_TRUE(is_empty(*scene, receiver_at({x, -0.25, -1}, {0, 0, 1}))) << x << " " << below;
    // From a wall, whose horizon cuts the lamp's plane but not the lamp; and the lamp's own
    // ceiling.
    EXPECT_TRUE(is_empty(*scene, receiver_at({1, 0.25, 0}, {-1, 0, 0}))) << below;
    EXPECT_TRUE(is_empty(*scene, receiver_at({0.1, 0.2, 0}, {1, 0, 0.25}))) << below;
  }
}

TEST(Shaft, FindsAnObstacleBeforeACornerOfTheLight) {
  for (const double gap : {-1e-3, 1e-3}) {
    SceneDescription d = room_with_lamp();
    // Halfway up and half as far to the side: at the edge of the shaft.
    const double x = 0.125 + gap;
    d.shapes.push_back(patch({x, -1, 0}, {0.9, -1, 0}, {x, 1, 0}, {0.9, 1, 0}));
    const auto scene = build(std::move(d));
    EXPECT_EQ(is_empty(*scene, receiver_at({0, 0, -1}, {0, 0, 1})), gap > 0) << gap;
  }
}

// Shadow rays end 16 roundings before a light.  An answer without rays would claim to be exact.
TEST(Shaft, FindsAnObstacleBetweenTheEndsOfRaysAndTheLight) {
  constexpr double kHeight = 1e6;
  for (const double below : {0.5, 0.0}) {
    const double z = kHeight - below;
    SceneDescription d = testing::description();
    d.shapes = {
        emissive(patch({-9, -9, kHeight}, {-9, 9, kHeight}, {9, -9, kHeight}, {9, 9, kHeight}), 10),
        patch({-99, -99, z}, {-99, 99, z}, {99, -99, z}, {99, 99, z}),
        // So that the scene keeps its origin.
        testing::floor(9, -kHeight)};
    EXPECT_EQ(is_empty(*build(std::move(d)), receiver_at({0, 0, kHeight - 1000}, {0, 0, 1})),
              below == 0)
        << below << " m below the light";
  }
}

TEST(Shaft, IgnoresSurfacesBehindTheLightOrBelowTheHorizon) {
  SceneDescription d = testing::description();
  d.shapes = {emissive(testing::floor(0.5, 1), 5, true), testing::floor(9, 1.5),
              testing::floor(9, -1), testing::floor(0.25, -0.25)};
  const auto scene = build(std::move(d));
  EXPECT_TRUE(is_empty(*scene, receiver_at({0, 0, 0}, {0, 0, 1})));
  // Beyond the lamp the ceiling is an obstacle.
  EXPECT_FALSE(is_empty(*scene, receiver_at({0, 0, 2}, {0, 0, -1})));
}

TEST(Shaft, OfInfiniteLights) {
  const auto scene_of = [](auto params, double x) {
    SceneDescription d = testing::description();
    d.shapes = {testing::floor(4), patch({x, -1, 1}, {x + 1, -1, 1}, {x, 1, 1}, {x + 1, 1, 1})};
    d.lights = {{std::move(params), {}}};
    return build(std::move(d));
  };
  const SunLightParams sun{{0, 0, 1}, 0.01, Rgb(1)};
  PortalLightParams portal;
  portal.corners_m = {Vec3{-1, -1, 2}, {-1, 1, 2}, {1, 1, 2}, {1, -1, 2}};
  const UniformInfiniteLightParams sky{Rgb(1)};
  const SurfaceHit receiver = receiver_at({0, 0, 0}, {0, 0, 1});
  EXPECT_TRUE(is_empty(*scene_of(sun, 0.01), receiver));
  EXPECT_FALSE(is_empty(*scene_of(sun, 0.004), receiver));
  EXPECT_TRUE(is_empty(*scene_of(portal, 0.51), receiver));
  EXPECT_FALSE(is_empty(*scene_of(portal, 0.49), receiver));
  EXPECT_FALSE(is_empty(*scene_of(sky, 0.51), receiver));
  EXPECT_TRUE(is_empty(*scene_of(sky, 0.51), receiver_at({0, 0, 1}, {0, 0, 1})));
  // An object beyond the portal hides the sky.
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(0.1, 3)};
  d.lights = {{portal, {}}};
  EXPECT_FALSE(is_empty(*build(std::move(d)), receiver));
}

// The lowest rays to a wide sun go farthest before they leave the scene above its walls.
TEST(Shaft, OfAWideSunFindsObstaclesOfItsLowestRays) {
  const auto scene_of = [](double top) {
    SceneDescription d = testing::description();
    // More than one box holds, and none that reaches the receiver.
    for (double y = -1; y < 1; y += 0.125)
      d.shapes.push_back(
          patch({4, y, top - 0.4}, {4, y + 0.125, top - 0.4}, {4, y, top}, {4, y + 0.125, top}));
    // From 22 to 68 degrees over the horizon: 1.6 m over it at the wall.
    d.lights = {{SunLightParams{{1, 0, 1}, 0.8, Rgb(1)}, {}}};
    return build(std::move(d));
  };
  for (const double top : {2.0, 1.5}) {
    const auto scene = scene_of(top);
    EXPECT_EQ(is_empty(*scene, receiver_at(-scene->origin(), {0, 0, 1})), top == 1.5);
  }
}

TEST(Shaft, IsUnknownForLightsWithoutAClosedFormAndForMotion) {
  SceneDescription d = testing::description();
  d.shapes = {emissive(shape(CylinderParams{}), 1),
              emissive(shape(testing::ball(0, [](const Vec3& p) { return p; })), 1),
              emissive(testing::floor(1, 3), 1, true)};
  const std::vector<KeyTransform> keys{{0, Transform()}, {1, Transform::translate({0, 0, 1})}};
  d.shapes[2].motion = std::make_shared<const Motion>(*Motion::create(keys));
  d.lights = {testing::point_light({0, 0, 5}, 1)};
  const auto scene = build(std::move(d));
  const Shafts shafts(*scene);
  for (std::uint32_t l = 0; l < scene->lights().size(); ++l) {
    EXPECT_FALSE(shafts.has_outline(l));
    EXPECT_FALSE(shafts.is_empty(receiver_at({0, 0, 8}, {0, 0, -1}), {0, 0, -1}, l));
  }
}

TEST(Shaft, InstancesCountWhereTheyAre) {
  for (const double x : {0.0, 1.5}) {
    SceneDescription d = testing::description();
    d.shapes = {testing::floor(4), emissive(testing::floor(0.5, 2), 1, true)};
    // A frame around nothing: its box intersects the shaft, the frame does not.
    ShapeList frame;
    for (const double side : {-1.0, 0.8})
      frame.push_back(patch({side, -1, 0}, {side + 0.2, -1, 0}, {side, 1, 0}, {side + 0.2, 1, 0}));
    d.objects = {{"frame", std::move(frame)}};
    d.instances = {{0, Transform::translate({x, 0, 1}) * *Transform::rotate(0.01, {0, 0, 1})}};
    const auto scene = build(std::move(d));
    EXPECT_TRUE(is_empty(*scene, receiver_at({x, 0, 0}, {0, 0, 1})) == (x == 0)) << x;
    EXPECT_FALSE(is_empty(*scene, receiver_at({x + 0.9, 0, 0.99}, {0, 0, 1}))) << x;
  }
}

/// Random shapes about the origin, some of them lamps, up to a size of about 1, times `scale` and
/// moved by `offset`.
SceneDescription clutter(std::mt19937& random, double scale, const Vec3& offset) {
  std::uniform_real_distribution<double> u(0, 1);
  const auto vector = [&] { return Vec3{2 * u(random) - 1, 2 * u(random) - 1, 2 * u(random) - 1}; };
  const auto place = [&] {
    return Transform::translate(offset) * *Transform::scale({scale, scale, scale}) *
           Transform::translate(vector() * 2.0) * *Transform::rotate(6 * u(random), vector());
  };
  SceneDescription d = testing::description();
  // Lamps have only shapes with an outline.
  const auto any = [&](double size, bool emits) {
    const Transform t = place();
    const auto bent_patch = [&](double bend) {
      return patch(t.point({-size, -size, 0}), t.point({size, -size, 0}), t.point({-size, size, 0}),
                   t.point({size, size, bend}));
    };
    switch (static_cast<int>((emits ? 4 : 7) * u(random))) {
      case 0:
        return shape(SphereParams{.radius_m = size, .world_from_object = t});
      case 1:
        return shape(DiskParams{.radius_m = size, .world_from_object = t});
      case 2:
        return shape(TriangleMeshData{
            {t.point({-size, 0, 0}), t.point({size, 0, 0}), t.point({0, size, 0})}, {}, {0, 1, 2}});
      case 3:
        return bent_patch(0);
      case 4:
        return bent_patch(size / 2);
      case 5:
        return shape(CylinderParams{.radius_m = size / 2, .z_max_m = size, .world_from_object = t});
      default:
        return shape(testing::ball(1, [&](const Vec3& p) { return t.point(p * size); }));
    }
  };
  for (int i = 0; i < 12; ++i) d.shapes.push_back(any(0.05 + 0.4 * u(random), false));
  for (int i = 0; i < 8; ++i)
    d.shapes.push_back(emissive(any(0.02 + 0.3 * u(random), true), 1, true));
  d.objects = {{"ball", {{testing::ball(1, [](const Vec3& p) { return p * 0.2; })}}}};
  for (int i = 0; i < 3; ++i) d.instances.push_back({0, place()});
  const auto around = [&](Vec3 p) { return offset + p * scale; };
  d.shapes.push_back(
      patch(around({-4, -4, -3}), around({4, -4, -3}), around({-4, 4, -3}), around({4, 4, -3})));
  const SunLightParams sun{vector(), 0.05, Rgb(1)};
  d.lights.emplace_back().params = sun;
  return d;
}

class ShaftProperty : public ::testing::TestWithParam<std::pair<double, Vec3>> {};

TEST_P(ShaftProperty, NoRayMeetsAnythingWhereItIsEmpty) {
  const auto [scale, offset] = GetParam();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0, 1);
  int tested = 0, reported_empty = 0, open = 0;
  for (int s = 0; s < 6; ++s) {
    const auto scene = build(clutter(random, scale, offset));
    const Shafts shafts(*scene);
    for (int i = 0; i < 60; ++i) {
      // A hit of a ray, with its normal turned as bump maps turn normals.
      const auto w = sample_uniform_sphere(Vec2f{u(random), u(random)});
      const Vec3 from = offset - scene->origin() +
                        Vec3{u(random) - 0.5, u(random) - 0.5, u(random) - 0.5} * (3 * scale);
      const auto hit = scene->closest_hit({Vec3f(from), w});
      if (!hit) continue;
      SurfaceHit receiver = *hit;
      if (dot(receiver.ng, Vec3(w)) > 0) receiver.ng = -receiver.ng;
      receiver.ns = receiver.ng;
      if (i % 5 == 0)
        receiver.ns = normalized(receiver.ns +
                                 Vec3(sample_uniform_sphere(Vec2f{u(random), u(random)}) * 0.3F));
      for (std::uint32_t l = 0; l < scene->lights().size(); ++l) {
        if (static_cast<std::int32_t>(l) == receiver.light) continue;
        const bool empty = shafts.is_empty(receiver, Vec3f(receiver.ns), l);
        const Rays rays = shoot(*scene, receiver, l, empty ? 1000 : 100, random);
        if (rays.lit == 0) continue;
        ++tested, reported_empty += empty, open += rays.blocked == 0;
        if (empty) {
          EXPECT_EQ(rays.blocked, 0) << "light " << l << " scene " << s << " of " << rays.lit;
        }
      }
    }
  }
  RecordProperty("tested", tested);
  RecordProperty("open", open);
  RecordProperty("reported_empty", reported_empty);
  // The test checks enough rays, and shafts are empty often enough.
  EXPECT_GT(reported_empty, 100);
  EXPECT_GT(reported_empty, 0.6 * open) << "of " << open << " that are";
  EXPECT_LT(reported_empty, tested);
}

INSTANTIATE_TEST_SUITE_P(Scales, ShaftProperty,
                         ::testing::Values(std::pair{1.0, Vec3{}},
                                           std::pair{1.0, Vec3{1e5, -2e5, 3e4}},
                                           std::pair{1e-20, Vec3{}}, std::pair{1e20, Vec3{}},
                                           std::pair{1e-3, Vec3{1, 2, 3}}));

TEST(Shaft, OfAnEmptySceneIsEmpty) {
  SceneDescription d = testing::description();
  d.lights = {{UniformInfiniteLightParams{Rgb(2)}, {}}};
  const auto scene = build(std::move(d));
  EXPECT_TRUE(is_empty(*scene, receiver_at({0, 0, 0}, {0, 0, 1})));
}

}  // namespace
}  // namespace lucerna

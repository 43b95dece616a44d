// Shadow maps agree with rays except at edges of shadows.  Disagreements are counted.  Only some
// lights have maps.
#include "server/visibility/shadow_map.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/estimate/light_visibility.h"
#include "server/estimate/render.h"
#include "server/queries/receiver_irradiance.h"
#include "server/visibility/shadow_maps.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using std::numbers::pi;

constexpr double kBoardHeight = 1, kLampHeight = 3, kHalfFloor = 4;

/// A floor, and over it a square board of half side 1, or none.
SceneDescription board_scene(bool has_board = true) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(kHalfFloor)};
  if (has_board) d.shapes.push_back(testing::floor(1, kBoardHeight));
  return d;
}
LightDescription spot(const Vec3& position, double cone_rad) {
  SpotLightParams p;
  p.position_m = position;
  p.axis = {0, 0, -1};
  p.intensity_cd = Rgb(100);
  p.cone_half_angle_rad = cone_rad;
  return {p, {}};
}
LightDescription distant() {
  return {DistantLightParams{.to_light = {0, 0, 1}, .illuminance_lx = Rgb(10)}, {}};
}

SurfaceHit floor_hit_at(double x, double y) {
  SurfaceHit hit;
  hit.position = {x, y, 0};
  hit.position_error = {1e-6f, 1e-6f, 1e-6f};
  hit.ng = {0, 0, 1};
  hit.ns = {0, 0, 1};
  return hit;
}

LightSample sample_of(const Scene& scene, const SurfaceHit& hit) {
  return scene.lights()[0].light->sample_li(Receiver(hit.position), {0.5, 0.5});
}
Ray ray_to(const Scene& scene, const SurfaceHit& hit) {
  return shadow_ray(hit, sample_of(scene, hit));
}

/// n x n points spread over the floor, not on a lattice that an edge might run along.
template <typename F>
void for_each_on_floor(int n, F&& f) {
  for (int i = 0; i < n * n; ++i) {
    const auto at = [&](double step) {
      const double turns = 0.5 + step * i;
      return kHalfFloor * (2 * (turns - std::floor(turns)) - 1);
    };
    f(floor_hit_at(at(0.7548776662466927), at(0.5698402909980532)));
  }
}

struct Agreement {
  int tested = 0, wrong = 0, wrong_away_from_edges = 0, shadowed = 0;
};

/// Compares with the shadow of the board by hand, a square of half side `half_shadow`.  Within
/// `band` of its edge the map may be wrong.
Agreement agreement(const Scene& scene, double half_shadow, double band, bool has_normal = true) {
  const LightVisibility visibility(scene, Methods{.visibility = VisibilityMethod::kShadowMaps});
  Agreement a;
  for_each_on_floor(600, [&](const SurfaceHit& hit) {
    if (sample_of(scene, hit).reason != NoLight::kNone) return;
    const auto shadowed_by_map = visibility.by_map(0, hit.position, has_normal ? hit.ng : Vec3{});
    ASSERT_TRUE(shadowed_by_map.has_value());
    const double outside = max_abs(Vec3{hit.position.x, hit.position.y, 0}) - half_shadow;
    ++a.tested;
    a.shadowed += *shadowed_by_map;
    if (*shadowed_by_map == (outside < 0)) return;
    ++a.wrong;
    if (std::fabs(outside) > band) ++a.wrong_away_from_edges;
  });
  return a;
}

TEST(ShadowMap, AgreesWithRaysExceptAtEdgesOfShadows) {
  SceneDescription d = board_scene();
  // By similar triangles.
  const double half_shadow = kLampHeight / (kLampHeight - kBoardHeight);
  const double diagonal = 1.5;  // of a texel, seen at 45 degrees
  for (const LightDescription& light :
       {testing::point_light({0, 0, kLampHeight}, 100), spot({0, 0, kLampHeight}, pi / 4)}) {
    d.lights = {light};
    const auto scene = testing::build(d);
    const double texel = 2.1 * kLampHeight / ShadowMaps::kLargestSide;
    const Agreement a = agreement(*scene, half_shadow, diagonal * texel);
    EXPECT_GT(a.tested, 600 * 600 / 3);
    EXPECT_GT(a.shadowed, 10000);
    EXPECT_EQ(a.wrong_away_from_edges, 0);
    // A map is not a ray: some points at the edge differ.
    EXPECT_GT(a.wrong, 0);
  }
  d.lights = {distant()};
  const auto scene = testing::build(d);
  const double texel = 2 * scene->sphere().radius_m / ShadowMaps::kLargestSide;
  const Agreement a = agreement(*scene, 1, diagonal * texel);
  EXPECT_EQ(a.tested, 600 * 600);
  EXPECT_EQ(a.wrong_away_from_edges, 0);
}

TEST(ShadowMap, AgreesWithRaysWithoutANormalExceptInGrazingLight) {
  SceneDescription d = board_scene();
  d.lights = {spot({0, 0, kLampHeight}, pi / 4)};
  const auto scene = testing::build(d);
  const Agreement a = agreement(*scene, 1.5, 0.02, false);
  EXPECT_GT(a.shadowed, 10000);
  EXPECT_EQ(a.wrong_away_from_edges, 0);
}

// A bias by the distance alone would fail: a texel of this lamp covers metres.
TEST(ShadowMap, APlaneDoesNotShadowItselfInGrazingLight) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(100)};
  d.lights = {testing::point_light({0.3, 0.2, 0.05}, 1)};
  const auto scene = testing::build(std::move(d));
  const LightVisibility visibility(*scene, Methods{.visibility = VisibilityMethod::kShadowMaps});
  int shadowed = 0;
  for_each_on_floor(400, [&](SurfaceHit hit) {
    hit.position = hit.position * (99 / kHalfFloor);
    shadowed += visibility.by_map(0, hit.position, hit.ng).value();
  });
  EXPECT_EQ(shadowed, 0);
}

// Through all six faces of a cube, onto walls that face every way.
TEST(ShadowMap, LooksAllAroundALight) {
  SceneDescription d = testing::description();
  d.shapes = {testing::shape(testing::room()),
              testing::shape(testing::ball(2,
                                           [](const Vec3& p) {
                                             return p * 0.2 + Vec3{0.4, 0.3, 0.2};
                                           })),
              testing::shape(testing::ball(1, [](const Vec3& p) {
                return p * 0.2 - Vec3{0.4, 0.5, 0.3};
              }))};
  d.lights = {testing::point_light({0.05, -0.1, 0.07}, 1)};
  const auto scene = testing::build(std::move(d));
  const LightVisibility visibility(*scene, Methods{.visibility = VisibilityMethod::kShadowMaps});
  int wrong = 0, shadowed = 0, tested = 0;
  for (int i = 0; i < 40000; ++i) {
    // Directions of a spiral about a point from which the shadows are visible.
    const double z = (2 * i + 1) / 40000.0 - 1, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
    const auto hit = scene->closest_hit(
        {{-0.5f, 0.6f, -0.4f}, Vec3f(Vec3{r * std::cos(turn), r * std::sin(turn), z})});
    ASSERT_TRUE(hit);
    if (!(dot(hit->ng, sample_of(*scene, *hit).wi) > 0)) continue;
    const Ray ray = ray_to(*scene, *hit);
    const bool by_ray = scene->geometry().occluded(ray);
    ++tested;
    shadowed += by_ray;
    wrong += visibility.by_map(0, hit->position, hit->ng).value() != by_ray;
  }
  EXPECT_GT(tested, 20000);
  EXPECT_GT(shadowed, tested / 100);
  EXPECT_LT(shadowed, tested / 2);
  EXPECT_GT(wrong, 0);
  // The outlines of the balls and of their shadows: about 8 m on walls of 24 m2, within half of a
  // texel of 4 mm.
  EXPECT_LT(wrong, tested / 200);
}

/// Look-ups all over the floor, by the maps of another scene with the same light.
WorkCounts looked_up(const Scene& scene, const Scene& maps_of) {
  const LightVisibility visibility(scene, &shadow_maps(maps_of));
  WorkCounts work;
  for_each_on_floor(600, [&](const SurfaceHit& hit) {
    visibility.visible(0, hit.position, hit.ng, ray_to(scene, hit), work);
  });
  return work;
}

TEST(ShadowMap, CountsDisagreementsWithRays) {
  SceneDescription d = board_scene(), bare = board_scene(false);
  d.lights = bare.lights = {distant()};
  const auto scene = testing::build(d), without_board = testing::build(bare);
  const WorkCounts good = looked_up(*scene, *scene);
  EXPECT_EQ(good.map_lookups, 600u * 600);
  EXPECT_EQ(good.shadow_rays, good.map_compared);
  // One in 64, at random: within five standard deviations.
  const double expected = 600.0 * 600 / LightVisibility::kComparedOneIn;
  EXPECT_NEAR(static_cast<double>(good.map_compared), expected, 5 * std::sqrt(expected));
  EXPECT_LE(good.map_disagreed, good.map_compared / 100);

  // A map without the board is wrong in the whole shadow, 4 of 64 m2.
  const WorkCounts broken = looked_up(*scene, *without_board);
  EXPECT_EQ(broken.map_compared, good.map_compared);
  const double share = 4.0 / 64, n = static_cast<double>(broken.map_compared);
  EXPECT_NEAR(static_cast<double>(broken.map_disagreed) / n, share,
              5 * std::sqrt(share * (1 - share) / n));
}

IrradianceResult irradiance(const Scene& scene, VisibilityMethod visibility) {
  std::vector<IrradiancePoint> points;
  for_each_on_floor(40, [&](const SurfaceHit& hit) {
    points.push_back({hit.position, hit.position_error, hit.ns});
  });
  IrradianceSettings settings{.seed = 3, .samples_per_block = 1, .block_count = 2, .bounces = 0};
  settings.methods = {.closed_forms = ClosedForms::kOff, .visibility = visibility};
  return estimate_irradiance(scene, points, settings, {});
}

std::optional<ScenePart> maps_part(const Scene& scene) {
  const std::vector<ScenePart> parts = scene.parts();
  const auto found = std::ranges::find(parts, "shadow maps", &ScenePart::name);
  return found == parts.end() ? std::nullopt : std::optional(*found);
}

TEST(ShadowMaps, AreMadeAtTheirFirstUse) {
  SceneDescription d = board_scene();
  d.lights = {spot({0, 0, kLampHeight}, pi / 4),
              testing::point_light({3, 0, 2}, 10),
              {UniformInfiniteLightParams{Rgb(1)}, {}}};
  const auto scene = testing::build(d);
  const IrradianceResult by_rays = irradiance(*scene, VisibilityMethod::kRays);
  EXPECT_EQ(by_rays.work.map_lookups, 0u);
  EXPECT_FALSE(maps_part(*scene));
  const std::uint64_t before = scene->bytes();

  const IrradianceResult by_maps = irradiance(*scene, VisibilityMethod::kShadowMaps);
  EXPECT_GT(by_maps.work.map_lookups, 1600u);
  EXPECT_GT(by_maps.work.shadow_rays, by_maps.work.map_compared);  // of the sky
  const ScenePart part = maps_part(*scene).value();
  const std::uint64_t texels = 7u * ShadowMaps::kLargestSide * ShadowMaps::kLargestSide;
  EXPECT_GE(part.bytes, 4 * texels);
  EXPECT_LT(part.bytes, 4 * texels + 10000);
  EXPECT_EQ(scene->bytes(), before + part.bytes);
  EXPECT_GT(part.build_ms, 0);
  EXPECT_EQ(part.why, "a query used shadow maps: 2 of 3 lights, 1024 texels a side");
  // Most points are far from edges.
  int same = 0;
  for (std::size_t p = 0; p < by_rays.points.size(); ++p)
    same += by_rays.points[p].irradiance_lx.g == by_maps.points[p].irradiance_lx.g;
  EXPECT_GT(same, 1500);
}

TEST(ShadowMaps, OfManyLightsAreCoarserSoThatAllFit) {
  SceneDescription d = board_scene();
  for (int i = 0; i < 100; ++i)
    d.lights.push_back(testing::point_light({i * 0.1 - 5, 0, 2.0 + 0.01 * i}, 1));
  const auto scene = testing::build(d);
  const ShadowMaps maps(*scene);
  EXPECT_EQ(maps.side(), 236u);  // the square root of 2^25 / 600
  EXPECT_EQ(maps.bytes(), 0u);
  ASSERT_NE(maps.map(7), nullptr);
  const std::uint64_t one = maps.map(7)->bytes();
  EXPECT_GE(one, 6u * 236 * 236 * 4);
  EXPECT_GE(maps.bytes(), one);
  EXPECT_LT(maps.bytes(), 2 * one);
  EXPECT_EQ(maps.report()->why, "a query used shadow maps: 1 of 100 lights, 236 texels a side");
}

TEST(ShadowMaps, AreNotMadeForAreaLightsAndMotion) {
  const auto motion = [](const Vec3& shift) {
    const std::vector<KeyTransform> keys{{0, Transform()}, {1, Transform::translate(shift)}};
    return std::make_shared<const Motion>(*Motion::create(keys));
  };
  SceneDescription d = board_scene();
  d.shapes.push_back(testing::emissive(testing::floor(0.2, 2), 5));
  d.lights = {testing::point_light({0, 0, 3}, 10),
              testing::point_light({1, 0, 3}, 10),
              {SunLightParams{
                   .to_light = {0, 0, 1}, .angular_diameter_rad = 0.01, .illuminance_lx = Rgb(1)},
               {}},
              {UniformInfiniteLightParams{Rgb(1)}, {}},
              distant()};
  d.lights[1].motion = motion({0, 1, 0});
  {
    const auto scene = testing::build(d);
    const ShadowMaps maps(*scene);
    EXPECT_NE(maps.map(0), nullptr);
    for (const std::uint32_t l : {1u, 2u, 3u, 5u}) EXPECT_EQ(maps.map(l), nullptr) << l;
    EXPECT_NE(maps.map(4), nullptr);
  }
  // A board that moves.
  d.shapes[1].motion = motion({1, 0, 0});
  const auto scene = testing::build(d);
  const IrradianceResult answer = irradiance(*scene, VisibilityMethod::kShadowMaps);
  EXPECT_EQ(answer.work.map_lookups, 0u);
  EXPECT_EQ(answer.work.map_compared, 0u);
  EXPECT_GT(answer.work.shadow_rays, 0u);
  EXPECT_FALSE(maps_part(*scene));
  const IrradianceResult by_rays = irradiance(*scene, VisibilityMethod::kRays);
  for (std::size_t p = 0; p < by_rays.points.size(); ++p)
    ASSERT_EQ(answer.points[p].irradiance_lx.g, by_rays.points[p].irradiance_lx.g);
}

TEST(ShadowMaps, GiveTheSameBitsForAnyNumberOfThreads) {
  SceneDescription d = board_scene();
  d.camera.world_from_camera = Transform::look_at({0, -6, 3}, {0, 0, 0}, {0, 0, 1}).value();
  d.lights = {spot({0, 0, kLampHeight}, pi / 4), distant()};
  const auto with_threads = [&](int threads) {
    const auto scene = testing::build(d);  // its maps are made by as many
    TileSettings settings{.rect = {0, 0, 16, 12}, .seed = 5, .samples_per_block = 16};
    settings.methods.visibility = VisibilityMethod::kShadowMaps;
    tbb::task_arena arena(threads);
    return arena.execute([&] { return render_tile(*scene, settings, {}); });
  };
  const TileResult one = with_threads(1), two = with_threads(2);
  EXPECT_GT(one.work.map_lookups, 500u);
  EXPECT_GT(one.work.map_compared, 0u);
  EXPECT_EQ(one.work.map_lookups, two.work.map_lookups);
  EXPECT_EQ(one.work.map_compared, two.work.map_compared);
  EXPECT_EQ(one.work.map_disagreed, two.work.map_disagreed);
  for (std::size_t i = 0; i < one.channels.size(); ++i) {
    ASSERT_EQ(one.channels[i].sum, two.channels[i].sum);
    ASSERT_EQ(one.channels[i].deviation, two.channels[i].deviation);
  }
}

}  // namespace
}  // namespace lucerna

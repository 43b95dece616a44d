#include "server/queries/emission_queries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using ::lucerna::testing::build;
using ::lucerna::testing::description;

constexpr float kInf = std::numeric_limits<float>::infinity();

struct LeArrays {
  explicit LeArrays(std::size_t n) : radiance(3 * n), lights(n), status(n) {}
  bool operator==(const LeArrays&) const = default;

  std::vector<float> radiance;
  std::vector<std::uint64_t> lights;
  std::vector<int> status;
  std::uint64_t rays = 0;
};

LeArrays answer_to(const Scene& scene, const LeQuery& query) {
  LeArrays a(query.points.size());
  a.rays =
      le(scene, query, {a.radiance.data(), a.lights.data(), a.status.data()}, {}).indirect_rays;
  return a;
}

/// A one-sided panel of 7 cd/m2 at z = 2 that emits upwards, a black one at z = 3, and two skies.
SceneDescription panels() {
  SceneDescription d = description();
  d.shapes.push_back(testing::emissive(testing::floor(1, 2), 7));
  d.shapes.push_back(testing::floor(1, 3));
  d.lights.push_back({UniformInfiniteLightParams{Rgb(0.5)}, {"test.pbrt", 2, 1}});
  d.lights.push_back({UniformInfiniteLightParams{Rgb(0.25)}, {"test.pbrt", 3, 1}});
  return d;
}

std::uint64_t id_of_area_light(const Scene& scene) {
  for (const SceneLight& l : scene.lights()) {
    if (l.light->has_surface()) return l.id;
  }
  return 0;
}

TEST(Le, IsThatOfTheFirstSurfaceElseOfAllSkies) {
  const auto scene = build(panels());
  // Five rays: from between the panels down onto the lit side; up to the black panel; from below
  // onto the light's dark side; past both; down from above the black panel.
  const std::vector<float> points{0, 0, 2.5F, 0, 0, 2.5F, 0, 0, 0, 5, 0, 0, 0, 0, 4};
  const std::vector<float> directions{0, 0, -3, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, -1};
  const LeArrays a = answer_to(*scene, {.points = {{}, points}, .directions = directions});
  EXPECT_EQ(a.status, std::vector<int>(5, 1));
  const auto red = [&](std::size_t i) { return a.radiance[3 * i]; };
  EXPECT_EQ(red(0), 7);
  EXPECT_EQ(red(1), 0);
  EXPECT_EQ(red(2), 0);
  EXPECT_EQ(red(3), 0.75F);
  EXPECT_EQ(red(4), 0);
  const std::uint64_t area = id_of_area_light(*scene);
  const std::uint64_t sky = scene->lights()[scene->lights().infinite()[0]].id;
  EXPECT_EQ(a.lights, (std::vector<std::uint64_t>{area, 0, 0, sky, 0}));
  EXPECT_EQ(a.rays, 5U);
}

TEST(Le, OfOneLightIgnoresOtherLights) {
  const auto scene = build(panels());
  const std::vector<float> points{0, 0, 2.5F, 5, 0, 0};
  const std::vector<float> directions{0, 0, -1, 0, 0, 1};
  const std::uint32_t second_sky = scene->lights().infinite()[1];
  const LeArrays sky =
      answer_to(*scene, {.points = {{}, points}, .directions = directions, .light = second_sky});
  EXPECT_EQ(sky.radiance, (std::vector<float>{0, 0, 0, 0.25F, 0.25F, 0.25F}));
  EXPECT_EQ(sky.lights, (std::vector<std::uint64_t>{0, scene->lights()[second_sky].id}));
  const std::uint32_t area = *scene->lights().find(id_of_area_light(*scene));
  const LeArrays panel =
      answer_to(*scene, {.points = {{}, points}, .directions = directions, .light = area});
  EXPECT_EQ(panel.radiance, (std::vector<float>{7, 7, 7, 0, 0, 0}));
}

TEST(Le, FromAPointTypedOnASurfaceLooksAwayFromIt) {
  SceneDescription d = description();
  // Far from zero, where vertices are rounded.  The start is on the emitter itself.
  d.shapes.push_back(testing::emissive(testing::floor(1000, 1000.1), 7, true));
  d.lights.push_back({UniformInfiniteLightParams{Rgb(0.5)}, {"test.pbrt", 2, 1}});
  const auto scene = build(std::move(d));
  const std::vector<float> offsets{1, 2, 0, 1, 2, 0, 1, 2, 1};
  const std::vector<float> directions{0.1F, 0, 1, 0, 0.2F, -1, 0, 0, -1};
  const LeArrays a =
      answer_to(*scene, {.points = {{0, 0, 1000.1}, offsets}, .directions = directions});
  EXPECT_EQ(a.radiance[0], 0.5F);
  EXPECT_EQ(a.radiance[3], 0.5F);
  EXPECT_EQ(a.radiance[6], 7);
}

TEST(Le, BadItemsFailAlone) {
  const auto scene = build(panels());
  const std::vector<float> points{kInf, 0, 0, 5, 0, 0, 5, 0, 0};
  const std::vector<float> directions{0, 0, 1, 0, 0, 0, 0, 0, 1};
  const LeArrays a = answer_to(*scene, {.points = {{}, points}, .directions = directions});
  EXPECT_EQ(a.status[0], static_cast<int>(ItemResult::kInvalidInput));
  EXPECT_EQ(a.status[1], static_cast<int>(ItemResult::kInvalidInput));
  EXPECT_EQ(a.status[2], static_cast<int>(ItemResult::kOk));
  EXPECT_EQ(a.radiance, (std::vector<float>{0, 0, 0, 0, 0, 0, 0.75F, 0.75F, 0.75F}));
}

TEST(Le, IsOutOfRangeWhereASumDoesNotFitFloats) {
  SceneDescription d = description();
  for (int i = 0; i < 2; ++i) {
    d.lights.push_back({UniformInfiniteLightParams{Rgb(3e38)}, {"test.pbrt", 2, 1}});
  }
  const auto scene = build(std::move(d));
  const std::vector<float> point{0, 0, 0}, direction{0, 0, 1};
  const LeArrays a = answer_to(*scene, {.points = {{}, point}, .directions = direction});
  EXPECT_EQ(a.status[0], static_cast<int>(ItemResult::kOutOfRange));
  EXPECT_EQ(a.radiance[0], 0);
}

struct RayArrays {
  explicit RayArrays(std::size_t n)
      : offsets(3 * n),
        directions(3 * n),
        normals(3 * n),
        value(3 * n),
        position(n),
        direction(n),
        lights(n),
        probability(n),
        status(n) {}
  SampleLeAnswer answer() {
    return {offsets.data(),   directions.data(), normals.data(),     value.data(), position.data(),
            direction.data(), lights.data(),     probability.data(), status.data()};
  }
  std::vector<float> offsets, directions, normals, value, position, direction;
  std::vector<std::uint64_t> lights;
  std::vector<double> probability;
  std::vector<int> status;
};

TEST(SampleLe, WithoutLightsTheSelectionProbabilityIsOne) {
  SceneDescription d = description();
  d.shapes.push_back(testing::floor(1));
  const auto scene = build(std::move(d));
  RayArrays rays(2);
  const std::vector<float> u{0.5F, 0.5F, 0.5F, 0.5F, std::nanf(""), 0.5F, 0.5F, 0.5F};
  const std::vector<double> u_light{0.5, 0.5};
  sample_le(*scene, {.rays = 2, .u = u, .u_light = u_light}, rays.answer(), {});
  EXPECT_EQ(rays.status, (std::vector<int>{static_cast<int>(ItemResult::kBlack),
                                           static_cast<int>(ItemResult::kInvalidInput)}));
  EXPECT_EQ(rays.probability, (std::vector<double>{1, 1}));
  EXPECT_EQ(rays.lights, (std::vector<std::uint64_t>{0, 0}));
  EXPECT_EQ(rays.value, std::vector<float>(6));
}

TEST(SampleLe, OfABlackLightHasOnlyAStatus) {
  SceneDescription d = description();
  d.lights.push_back(testing::point_light({1, 2, 3}, 0));
  const auto scene = build(std::move(d));
  RayArrays rays(1);
  sample_le(*scene, {.rays = 1, .light = 0, .seed = SeedRange{}}, rays.answer(), {});
  EXPECT_EQ(rays.status[0], static_cast<int>(ItemResult::kBlack));
  EXPECT_EQ(rays.value, std::vector<float>(3));
  EXPECT_EQ(rays.directions, std::vector<float>(3));
  EXPECT_EQ(rays.direction[0], 0);
}

TEST(SampleLe, StartsAreAboutTheScenesOrigin) {
  SceneDescription d = description();
  d.lights.push_back(testing::point_light({1000, 2000, 3000}, 5));
  const auto scene = build(std::move(d));
  RayArrays rays(1);
  sample_le(*scene, {.rays = 1, .light = 0, .seed = SeedRange{}}, rays.answer(), {});
  EXPECT_EQ(rays.status[0], static_cast<int>(ItemResult::kOk));
  const Vec3 at = scene->origin() + Vec3(triple(rays.offsets, 0));
  EXPECT_NEAR(length(at - Vec3(1000, 2000, 3000)), 0, 1e-3);
  EXPECT_EQ(rays.value, (std::vector<float>{5, 5, 5}));
}

}  // namespace
}  // namespace lucerna

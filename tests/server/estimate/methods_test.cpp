// All methods give the same light, in a scene with every kind of light and in one with a few.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/estimate/direct_light.h"
#include "server/estimate/render.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/server/extremes/invariant_scene.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;

constexpr LightSelection kSelections[] = {LightSelection::kAutomatic, LightSelection::kAll,
                                          LightSelection::kUniform, LightSelection::kPower,
                                          LightSelection::kBvh};
constexpr Combination kCombinations[] = {Combination::kPowerHeuristic,
                                         Combination::kBalanceHeuristic, Combination::kLights,
                                         Combination::kSurfaces};

/// A lamp, a bulb and a sky over a floor with a board in the way.
std::shared_ptr<const Scene> few_lights() {
  SceneDescription d = testing::description(0.6);
  d.shapes = {testing::floor(20), testing::patch({0.5, -1, 1}, {2, -1, 1}, {0.5, 1, 1}, {2, 1, 1}),
              testing::emissive(testing::patch({-1, -1, 3}, {-1, 1, 3}, {1, -1, 3}, {1, 1, 3}), 5)};
  d.lights = {testing::point_light({2, 0, 3}, 20)};
  d.lights.push_back({UniformInfiniteLightParams{Rgb(0.5, 0.7, 1)}, {}});
  return build(std::move(d));
}

/// Three lamps, a bulb and a sun over a bright floor, with a board in the way.  The lamps are so
/// large that reflected directions find them often.
std::shared_ptr<const Scene> several_lamps() {
  SceneDescription d = testing::description(0.8);
  d.shapes = {testing::floor(20), testing::patch({0.5, -1, 1}, {2, -1, 1}, {0.5, 1, 1}, {2, 1, 1}),
              testing::emissive(testing::patch({-4, -4, 3}, {-4, 4, 3}, {4, -4, 3}, {4, 4, 3}), 1),
              testing::emissive(
                  testing::patch({-3, -3, 0.5}, {-3, 3, 0.5}, {-3, -3, 3}, {-3, 3, 3}), 2, true),
              testing::emissive(
                  testing::shape(SphereParams{
                      .radius_m = 0.8, .world_from_object = Transform::translate({3, 0.5, 1.2})}),
                  3)};
  d.lights = {testing::point_light({2, 0, 2.5}, 1)};
  d.lights.push_back({DistantLightParams{.illuminance_lx = Rgb(0.5, 0.5, 0.5)}, {}});
  return build(std::move(d));
}

std::string name_of(const Methods& m) {
  return "selection " + std::to_string(int(m.light_selection)) + ", combination " +
         std::to_string(int(m.combination)) + ", sampler " + std::to_string(int(m.sampler)) +
         ", points " + std::to_string(m.samples_per_light.value_or(0));
}

/// Each setting of each method occurs once; not all combinations do.
std::vector<Methods> all_methods() {
  std::vector<Methods> all;
  for (const LightSelection selection : kSelections)
    for (const Combination combination : kCombinations)
      for (const std::optional<std::uint32_t> points : {std::optional<std::uint32_t>(), {3}})
        all.push_back({.light_selection = selection,
                       .samples_per_light = points,
                       .sampler = points ? Sampler::kIndependent : Sampler::kSobol,
                       .combination = combination,
                       .closed_forms = ClosedForms::kOff});
  return all;
}

IrradianceEstimate estimate(const Scene& scene, const Vec3& world, const Methods& methods,
                            std::uint32_t samples, std::optional<std::uint32_t> bounces) {
  const IrradiancePoint point{world - scene.origin(), {1e-5F, 1e-5F, 1e-5F}, {0, 0, 1}};
  const IrradianceSettings settings{.seed = 11,
                                    .samples_per_block = samples / 64,
                                    .block_count = 64,
                                    .bounces = bounces,
                                    .methods = methods};
  return estimate_irradiance(scene, std::span(&point, 1), settings, {}).points[0];
}

void expect_same_irradiance(const Scene& scene, const Vec3& at,
                            std::optional<std::uint32_t> bounces, std::uint32_t samples,
                            bool small_lamps = false) {
  const IrradianceEstimate truth = estimate(
      scene, at, {.light_selection = LightSelection::kAll, .closed_forms = ClosedForms::kOff},
      16 * samples, bounces);
  for (const Methods& m : all_methods()) {
    // Directions that find light once in a thousand samples underestimate their own standard error.
    if (small_lamps && m.combination == Combination::kSurfaces) continue;
    const IrradianceEstimate e = estimate(scene, at, m, samples, bounces);
    const double error = std::hypot(e.illuminance_error_lx, truth.illuminance_error_lx);
    EXPECT_NEAR(luminance(e.irradiance_lx), luminance(truth.irradiance_lx), 4.5 * error)
        << name_of(m);
    EXPECT_LT(error, 0.2 * luminance(truth.irradiance_lx)) << name_of(m);
  }
}

TEST(Methods, GiveTheSameDirectLightOfFewLights) {
  expect_same_irradiance(*few_lights(), {1, 0.2, 0}, 0, 4096);
}

TEST(Methods, GiveTheSameReflectedLightOfFewLights) {
  expect_same_irradiance(*few_lights(), {1, 0.2, 0}, 2, 4096);
}

TEST(Methods, GiveTheSameReflectedLightOfSeveralLamps) {
  expect_same_irradiance(*several_lamps(), {1, 0.2, 0}, 3, 8192);
}

TEST(Methods, OneOfSeveralLampsIsDrawnAfterAReflection) {
  const auto scene = several_lamps();
  const auto rays = [&](LightSelection selection) {
    const IrradiancePoint point{
        Vec3(1, 0.2, 0) - scene->origin(), {1e-5F, 1e-5F, 1e-5F}, {0, 0, 1}};
    const IrradianceSettings settings{.samples_per_block = 64,
                                      .block_count = 16,
                                      .bounces = 3,
                                      .methods = {.light_selection = selection,
                                                  .combination = Combination::kLights,
                                                  .closed_forms = ClosedForms::kOff}};
    const WorkCounts work = estimate_irradiance(*scene, std::span(&point, 1), settings, {}).work;
    return static_cast<double>(work.shadow_rays) / static_cast<double>(work.indirect_rays);
  };
  EXPECT_LT(rays(LightSelection::kAutomatic), 0.9 * rays(LightSelection::kAll));
}

TEST(Methods, GiveTheSameDirectLightOfEveryKindOfLight) {
  // At places that are not just below the luminaires.
  expect_same_irradiance(*build(testing::invariant_scene()),
                         testing::kEveryLightMiddle + Vec3{0.37, 0.21, 0}, 0, 8192, true);
}

TEST(Methods, GiveTheSamePicture) {
  const auto scene = few_lights();
  const auto mean = [&](const Methods& methods, std::uint64_t blocks) {
    TileSettings settings{.rect = {0, 0, 16, 12},
                          .samples_per_block = 16,
                          .block_count = blocks,
                          .bounces = 1,
                          .methods = methods};
    double sum = 0, variance = 0;
    for (const BlockStatistics& c : render_tile(*scene, settings, {}).channels) {
      const auto n = double(blocks);
      sum += c.sum / n;
      variance += c.deviation / (n * (n - 1));
    }
    return std::pair(sum, variance);
  };
  const auto [truth, its_variance] = mean({}, 64);
  EXPECT_GT(truth, 1);
  for (const Methods& m : all_methods()) {
    const auto [value, variance] = mean(m, 8);
    // The channels of a pixel are correlated.
    EXPECT_NEAR(value, truth, 4.5 * std::sqrt(3 * (variance + its_variance))) << name_of(m);
    EXPECT_LT(std::sqrt(variance), 0.1 * truth) << name_of(m);
  }
}

TEST(Methods, IndependentSamplesScatterMoreThanSobolPoints) {
  const auto scene = few_lights();
  const auto error = [&](Sampler sampler) {
    return estimate(*scene, {-1, 0, 0}, {.sampler = sampler, .closed_forms = ClosedForms::kOff},
                    65536, 0)
        .illuminance_error_lx;
  };
  EXPECT_GT(error(Sampler::kIndependent), 4 * error(Sampler::kSobol));
}

TEST(Methods, MorePointsOnALightScatterLess) {
  const auto scene = few_lights();
  const auto error = [&](std::uint32_t points) {
    return estimate(*scene, {1, 0.2, 0},
                    {.light_selection = LightSelection::kAll,
                     .samples_per_light = points,
                     .combination = Combination::kLights,
                     .closed_forms = ClosedForms::kOff},
                    1024, 0)
        .illuminance_error_lx;
  };
  EXPECT_LT(error(16), 0.5 * error(1));
}

TEST(Methods, AQueryOverridesTheScenesPointsPerLight) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9), testing::emissive(testing::floor(1, 2), 5, true)};
  d.shapes[1].emission->samples = 4;
  const auto scene = build(std::move(d));
  const auto rays = [&](std::optional<std::uint32_t> points) {
    const IrradiancePoint point{{0, 0, 0}, {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}};
    const IrradianceSettings settings{.samples_per_block = 4,
                                      .block_count = 16,
                                      .bounces = 0,
                                      .methods = {.samples_per_light = points,
                                                  .combination = Combination::kLights,
                                                  .closed_forms = ClosedForms::kOff}};
    return estimate_irradiance(*scene, std::span(&point, 1), settings, {}).work.shadow_rays;
  };
  EXPECT_EQ(rays({}), 4 * 64u);
  EXPECT_EQ(rays(1), 64u);
  EXPECT_EQ(rays(7), 7 * 64u);
}

// The rule of photometry: at five times its largest dimension, a lamp counts as a point to 1%.
TEST(Methods, FarLampsCountAsPointsAndNearOnesDoNot) {
  SceneDescription d = testing::description();
  d.shapes = {
      testing::emissive(testing::patch({-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}), 5),
      testing::emissive(
          testing::shape(SphereParams{.world_from_object = Transform::translate({0, 0, 3})}), 2)};
  const auto scene = build(std::move(d));
  for (const double radii : {4.0, 8.0, 32.0}) {
    const double far = radii * std::sqrt(3.0);  // of the larger lamp
    const Methods methods{.far_light_radii = radii, .closed_forms = ClosedForms::kOff};
    const auto at = [&](const Vec3& p, const Methods& m) {
      const IrradiancePoint point{p - scene->origin(), {1e-6F, 1e-6F, 1e-6F}, {-0.6F, 0, 0.8F}};
      const IrradianceSettings settings{
          .samples_per_block = 256, .block_count = 64, .bounces = 0, .methods = m};
      return estimate_irradiance(*scene, std::span(&point, 1), settings, {}).points[0];
    };
    const Vec3 direction = normalized(Vec3{0.7, 0.1, 0.3});
    const IrradianceEstimate as_points = at(direction * (far + 4), methods);
    const IrradianceEstimate truth = at(direction * (far + 4), {.combination = Combination::kLights,
                                                                .closed_forms = ClosedForms::kOff});
    EXPECT_TRUE(as_points.exact);
    EXPECT_NE(luminance(as_points.irradiance_lx), luminance(truth.irradiance_lx));
    EXPECT_NEAR(luminance(as_points.irradiance_lx) / luminance(truth.irradiance_lx), 1,
                2 / (radii * radii) + 5 * truth.illuminance_error_lx);
    EXPECT_FALSE(at({1, 0, 1}, methods).exact);
  }
}

}  // namespace
}  // namespace lucerna

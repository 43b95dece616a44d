// The coverage of sampled power intervals over repeats, with a sample count and with a target
// error.  It is measured for single lights and for all of them together.
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <numbers>
#include <vector>

#include "server/queries/queries.h"
#include "server/queries/sampled_power.h"
#include "tests/lights/grey_picture.h"
#include "tests/server/estimate/coverage.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

using std::numbers::pi;

/// A sphere, a triangle and a disk with pictures on them.
std::shared_ptr<const Scene> lamps() {
  SceneDescription d = description();
  d.shapes = {
      emissive({SphereParams{.world_from_object = Transform::translate({0, 0, 3})}}, 5),
      emissive(shape(TriangleMeshData{
                   {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {0, 1, 2}, {{0, 0}, {1, 0}, {0, 1}}}),
               20),
      emissive({DiskParams{.radius_m = 0.5}}, 3)};
  for (ShapeDescription& s : d.shapes)
    s.emission->picture = grey(3, 2, {0, 1, 4, 2, 0.5, 0.1F}, ImageFilter::kBilinear);
  return build(std::move(d));
}

/// The coverage for every light; the last is for all lights together.
std::vector<Coverage> coverage_of(const Scene& scene, SampledPowerSettings settings) {
  std::vector<std::uint32_t> all;
  std::vector<Coverage> coverage;
  double total = 0;
  for (std::uint32_t l = 0; l < scene.lights().size(); ++l) {
    all.push_back(l);
    total += luminance(light_power(scene, l).lumens);
    coverage.emplace_back(luminance(light_power(scene, l).lumens));
  }
  coverage.emplace_back(total);
  std::vector<SampledPowers> answers(repeats());
  tbb::parallel_for(std::size_t{0}, answers.size(), [&](std::size_t i) {
    SampledPowerSettings s = settings;
    s.seed = i;
    answers[i] = sample_powers(scene, all, s, {});
  });
  for (const SampledPowers& r : answers)
    for (std::size_t l = 0; l < coverage.size(); ++l) {
      const SampledPower& p = l < all.size() ? r.lights[l] : r.total;
      coverage[l].add(luminance(p.lumens), p.interval_lm);
    }
  return coverage;
}

TEST(PowerCoverage, ByACount) {
  const auto scene = lamps();
  for (const std::uint32_t each : {8U, 64U}) {
    const std::vector<Coverage> c = coverage_of(*scene, {.samples_per_block = each});
    for (std::size_t l = 0; l < c.size(); ++l)
      expect_covered(c[l], "light " + std::to_string(l) + ", " + std::to_string(each) + " rays");
  }
}

TEST(PowerCoverage, ByATarget) {
  const auto scene = lamps();
  for (const double relative : {0.05, 0.005}) {
    const std::vector<Coverage> c =
        coverage_of(*scene, {.target = TargetError{.relative = relative}});
    for (std::size_t l = 0; l < c.size(); ++l)
      expect_covered(c[l], "light " + std::to_string(l) + " within " + std::to_string(relative));
  }
}

// Samples by the intensity, or by the cosine, are all equal.
TEST(SampledPower, IsExactWhereTheDensityFollowsTheLight) {
  SceneDescription d = description();
  d.lights = {{SpotLightParams{
                   .intensity_cd = Rgb(100), .cone_half_angle_rad = 1, .falloff_start_rad = 0.2},
               {}},
              point_light({1, 2, 3}, 5)};
  d.shapes = {emissive(patch({-1, -1, 2}, {-1, 1, 2}, {1, -1, 2}, {1, 1, 2}), 5, true)};
  const auto scene = build(std::move(d));
  const std::uint32_t all[] = {0, 1, 2};
  const SampledPowers r = sample_powers(*scene, all, {.samples_per_block = 4}, {});
  for (const std::uint32_t l : all) {
    const double exact = luminance(light_power(*scene, l).lumens);
    EXPECT_NEAR(luminance(r.lights[l].lumens), exact, 1e-6 * exact) << l;
    EXPECT_LE(r.lights[l].standard_error_lm, 1e-6 * exact) << l;
  }
}

TEST(SampledPower, DoesNotDependOnOtherLights) {
  const auto scene = lamps();
  const std::uint32_t all[] = {0, 1, 2}, two[] = {2, 1};
  for (const auto& target :
       {std::optional<TargetError>(), std::optional(TargetError{.relative = 0.01})}) {
    const SampledPowerSettings settings{.seed = 5, .samples_per_block = 16, .target = target};
    const SampledPowers a = sample_powers(*scene, all, settings, {});
    const SampledPowers b = sample_powers(*scene, two, settings, {});
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(a.lights[two[i]].lumens, b.lights[i].lumens);
      EXPECT_EQ(a.lights[two[i]].interval_lm.upper, b.lights[i].interval_lm.upper);
      EXPECT_EQ(a.lights[two[i]].samples, b.lights[i].samples);
    }
    EXPECT_EQ(b.total.samples, b.lights[0].samples + b.lights[1].samples);
  }
}

TEST(SampledPower, OfATargetHasTheBitsOfAQueryForItsCount) {
  const auto scene = lamps();
  const std::uint32_t all[] = {0, 1, 2};
  const SampledPowers r =
      sample_powers(*scene, all, {.seed = 5, .target = TargetError{.relative = 0.005}}, {});
  for (const std::uint32_t l : all) {
    EXPECT_EQ(r.lights[l].samples % 16, 0U);
    const auto each = static_cast<std::uint32_t>(r.lights[l].samples / 16);
    const SampledPowers again =
        sample_powers(*scene, std::span(&all[l], 1), {.seed = 5, .samples_per_block = each}, {});
    EXPECT_EQ(again.lights[0].lumens, r.lights[l].lumens);
    EXPECT_EQ(again.lights[0].interval_lm.lower, r.lights[l].interval_lm.lower);
  }
}

TEST(SampledPower, StopsOnRequest) {
  const auto scene = lamps();
  const std::uint32_t all[] = {0, 1, 2};
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(
      sample_powers(*scene, all, {.samples_per_block = 1U << 28}, stop.get_token()).stopped);
}

}  // namespace
}  // namespace lucerna::testing

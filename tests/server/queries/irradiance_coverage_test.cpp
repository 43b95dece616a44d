// The coverage of irradiance intervals over repeats, with a sample count and with a target error.
// Some scenes are smooth.  In one only one sample in a thousand finds light.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "server/queries/receiver_irradiance.h"
#include "tests/server/estimate/coverage.h"
#include "tests/server/queries/irradiance_questions.h"

namespace lucerna::testing {
namespace {

Coverage coverage_of(const Question& q, IrradianceSettings settings) {
  settings.bounces = q.bounces;
  settings.seed = 6;
  settings.methods.closed_forms = ClosedForms::kOff;
  const std::vector<IrradiancePoint> points(
      repeats(), {q.receiver - q.scene->origin(), {1e-6F, 1e-6F, 1e-6F}, Vec3(q.normal)});
  const IrradianceResult r = estimate_irradiance(*q.scene, points, settings, {});
  Coverage c(q.truth);
  for (const IrradianceEstimate& e : r.points) c.add(luminance(e.irradiance_lx), e.illuminance_lx);
  return c;
}

// Answers whose scatter is known: a normal distribution, and the same with a mean that is 0.2
// deviations off, as samples that influence their own number would have it.
TEST(Coverage, NoticesWrongWidthsAndABias) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Coverage right(0), narrow(0), wide(0), biased(0);
  for (std::uint64_t i = 0; i < repeats(); ++i) {
    const double e = normal(random);
    const auto add = [&](Coverage& c, double mean, double width) {
      c.add(mean + e, {mean + e - 1.96 * width, mean + e + 1.96 * width});
    };
    add(right, 0, 1), add(narrow, 0, 0.6), add(wide, 0, 1.8), add(biased, 0.2, 1);
  }
  expect_covered(right, "right");
  EXPECT_FALSE(narrow.holds_enough()) << narrow.held();
  EXPECT_FALSE(wide.holds_no_more()) << wide.held();
  EXPECT_GT(std::fabs(biased.bias()), 4);
}

TEST(IrradianceCoverage, OfSmoothLightByACount) {
  for (const Question& q : {lamp(), furnace()})
    for (const std::uint32_t each : {4U, 16U, 64U})
      expect_covered(coverage_of(q, {.samples_per_block = each, .block_count = 16}),
                     q.name + ", " + std::to_string(each) + " samples a block");
}

TEST(IrradianceCoverage, OfSmoothLightByATarget) {
  for (const Question& q : {lamp(), furnace()})
    for (const double relative : {0.1, has_time_for_large_counts() ? 0.02 : 0.04})
      expect_covered(
          coverage_of(q, {.block_count = 16, .target = TargetError{.relative = relative}}),
          q.name + " within " + std::to_string(relative));
}

std::vector<Question> at_edges() {
  std::vector<Question> result = {half_a_sky()};
  for (const double end : {-0.3, 0.01, 0.2}) result.push_back(partly_hidden(end));
  if (has_time_for_large_counts())
    for (const double end : {-0.45, 0.0, 0.06, 0.45}) result.push_back(partly_hidden(end));
  return result;
}

// Low-discrepancy points along a straight edge hide nearly as many samples in every block.  So
// means of blocks take few values, and those that occur say little about the others.  Intervals
// may be too wide.
TEST(IrradianceCoverage, OfLightAtAnEdgeByACount) {
  for (const Question& q : at_edges())
    for (const std::uint32_t each : {8U, 16U, 32U, 64U})
      expect_covered_at_least(coverage_of(q, {.samples_per_block = each, .block_count = 16}),
                              q.name + ", " + std::to_string(each) + " samples a block");
}

TEST(IrradianceCoverage, OfLightAtAnEdgeByATarget) {
  for (const Question& q : at_edges())
    for (const double relative : {0.1, has_time_for_large_counts() ? 0.02 : 0.04})
      expect_covered_at_least(
          coverage_of(q, {.block_count = 16, .target = TargetError{.relative = relative}}),
          q.name + " within " + std::to_string(relative));
}

TEST(IrradianceCoverage, OfLightThroughAPinholeByACount) {
  const Question q = pinhole();
  for (const std::uint32_t each : {1U, 16U, 64U, 256U, 1024U})
    if (each < 1024 || has_time_for_large_counts())
      expect_covered_at_least(coverage_of(q, {.samples_per_block = each, .block_count = 16}),
                              std::to_string(each) + " samples a block");
}

TEST(IrradianceCoverage, OfLightThroughAPinholeByATarget) {
  const Question q = pinhole();
  for (const double relative : {1.0})
    expect_covered_at_least(
        coverage_of(q, {.block_count = 16, .target = TargetError{.relative = relative}}),
        "within " + std::to_string(relative));
}

TEST(IrradianceTarget, IsReached) {
  for (const Question& q : {lamp(), half_a_sky(), furnace()}) {
    const std::vector<IrradiancePoint> points(
        target_repeats(), {q.receiver - q.scene->origin(), {1e-6F, 1e-6F, 1e-6F}, Vec3(q.normal)});
    const IrradianceSettings settings{.block_count = 16,
                                      .target = TargetError{.relative = kTargetRelative},
                                      .bounces = q.bounces,
                                      .methods = {.closed_forms = ClosedForms::kOff}};
    const IrradianceResult r = estimate_irradiance(*q.scene, points, settings, {});
    expect_reached(
        q.truth, [&](std::size_t i) { return luminance(r.points[i].irradiance_lx); }, q.name);
  }
}

TEST(IrradianceTarget, HasTheBitsOfAQueryForItsCount) {
  for (const Question& q : {lamp(), furnace(), pinhole()}) {
    const std::vector<IrradiancePoint> points(
        20, {q.receiver - q.scene->origin(), {1e-6F, 1e-6F, 1e-6F}, Vec3(q.normal)});
    IrradianceSettings settings{.seed = 5,
                                .block_count = 16,
                                .target = TargetError{.relative = 0.1},
                                .bounces = q.bounces,
                                .methods = {.closed_forms = ClosedForms::kOff}};
    const IrradianceResult r = estimate_irradiance(*q.scene, points, settings, {});
    settings.target.reset();
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(r.costs[i].samples % 16, 0U);
      EXPECT_GE(r.costs[i].samples, 64U);
      settings.samples_per_block = static_cast<std::uint32_t>(r.costs[i].samples / 16);
      settings.first_item = i;
      const auto again = estimate_irradiance(*q.scene, std::span(&points[i], 1), settings, {});
      EXPECT_EQ(again.points[0].irradiance_lx, r.points[i].irradiance_lx) << q.name;
      EXPECT_EQ(again.points[0].illuminance_lx.upper, r.points[i].illuminance_lx.upper) << q.name;
    }
  }
}

TEST(IrradianceTarget, StopsAtTheLargestSampleCount) {
  // No light comes through a closed lid, for any number of samples.
  const auto scene = build(below_a_lid(0));
  const IrradiancePoint point{-scene->origin(), {1e-6F, 1e-6F, 1e-6F}, {0, 0, 1}};
  IrradianceSettings settings{
      .block_count = 16, .target = TargetError{.relative = 0.1, .max_samples = 1024}, .bounces = 0};
  auto r = estimate_irradiance(*scene, std::span(&point, 1), settings, {});
  EXPECT_EQ(r.costs[0].samples, 1024U);
  EXPECT_GT(r.points[0].illuminance_lx.upper, 0);
  EXPECT_EQ(r.points[0].zero_bound_lx, r.points[0].illuminance_lx.upper);
  // With an absolute floor above that bound.
  settings.target->absolute_floor = 1;
  r = estimate_irradiance(*scene, std::span(&point, 1), settings, {});
  EXPECT_EQ(r.costs[0].samples, 64U);
}

}  // namespace
}  // namespace lucerna::testing

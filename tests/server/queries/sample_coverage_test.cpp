// The intervals of SampleLi over repeats, with a target error and with a sample count.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "server/queries/li_estimates.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/server/estimate/coverage.h"
#include "tests/server/queries/irradiance_questions.h"
#include "tests/server/queries/li_samples.h"

namespace lucerna::testing {
namespace {

constexpr std::uint32_t kBlocks = 16;

/// Sampling by area.  Samples of the lamp by solid angle would be nearly equal.
struct Settings {
  std::optional<TargetError> target{};
  std::uint32_t samples_per_block = 0;  ///< without a target
  bool normals = true;
  LightSelection light_selection = LightSelection::kAutomatic;
};

struct Answered {
  IrradianceEstimate estimate;
  std::size_t samples;
};

/// The i-th repeat.
Answered answer(const Question& q, const Settings& settings, std::uint64_t i) {
  const std::vector<float> offset(3), normal = {q.normal.x, q.normal.y, q.normal.z};
  SampleLiQuery query;
  query.receivers = {q.receiver, offset};
  query.seed = SeedRange{.seed = 6, .first_item = i};
  query.test_visibility = true;
  if (settings.normals) query.normals = normal;
  query.methods.area_sampling = AreaSampling::kSquareRoot;
  query.methods.light_selection = settings.light_selection;
  const LiSampler sampler(*q.scene, query);
  WorkCounts work;
  const auto each = settings.target
                        ? samples_needed(sampler, 1, *settings.target, kBlocks, {}, work).value()
                        : equally_many(sampler, 1, settings.samples_per_block);
  const LiLayout layout(each, kBlocks);
  LiSamples samples(layout.size());
  std::vector<LiShare> shares(layout.size());
  fill_samples(sampler, layout, samples.answer(), shares, {});
  const LiEstimates e =
      estimates_of(sampler, layout, 1, kBlocks, settings.target.value_or(TargetError{}).confidence,
                   shares, samples.status, {}, 0);
  EXPECT_EQ(e.results[0], ItemResult::kOk);
  return {e.points[0], layout.size()};
}

Coverage covered(const Question& q, const Settings& settings) {
  return repeated(q.truth, [&](std::uint64_t i) {
    const IrradianceEstimate e = answer(q, settings, i).estimate;
    return Answer{luminance(e.irradiance_lx), e.illuminance_lx};
  });
}

/// The lamp and one beside it that is brighter, farther and smaller.
Question two_lamps() {
  Question q = lamp();
  SceneDescription d = below_a_lamp(0);
  const double x = 2, h = 0.25, z = 3, radiance = 40;
  d.shapes.push_back(
      emissive(patch({x - h, -h, z}, {x - h, h, z}, {x + h, -h, z}, {x + h, h, z}), radiance));
  q.name = "two lamps";
  q.scene = build(std::move(d));
  q.truth +=
      radiance * polygon_irradiance({{x - h, -h, z}, {x + h, -h, z}, {x + h, h, z}, {x - h, h, z}},
                                    {}, {0, 0, 1});
  return q;
}

/// The lamp at a small spherical receiver: radiance times solid angle.  A square of half side h at
/// distance z below its middle has 4 asin(h^2 / (h^2 + z^2)).
Question lamp_from_everywhere() {
  Question q = lamp();
  q.name = "spherical";
  q.truth = 5 * 4 * std::asin(1.0 / 5);
  return q;
}

TEST(SampleCoverage, OfSmoothLightByATarget) {
  for (const double relative : {0.1, 0.02}) {
    const std::string within = " within " + std::to_string(relative);
    const Settings settings{.target = TargetError{.relative = relative}};
    for (const Question& q : {lamp(), two_lamps()})
      expect_covered(covered(q, settings), q.name + within);
    Settings by_power = settings, as_a_sphere = settings;
    by_power.light_selection = LightSelection::kPower;
    expect_covered(covered(two_lamps(), by_power), "two lamps by power" + within);
    as_a_sphere.normals = false;
    expect_covered(covered(lamp_from_everywhere(), as_a_sphere), "spherical" + within);
  }
}

TEST(SampleCoverage, OfSmoothLightByACount) {
  for (const Question& q : {lamp(), two_lamps()})
    for (const std::uint32_t each : {4U, 64U})
      expect_covered(covered(q, {.samples_per_block = each}),
                     q.name + ", " + std::to_string(each) + " samples a block");
}

// As in tests/server/queries/irradiance_coverage_test.cpp.
TEST(SampleCoverage, OfLightAtAnEdge) {
  for (const Question& q : {half_a_sky(), partly_hidden(0.01), partly_hidden(0.2)}) {
    for (const double relative : {0.1, 0.02})
      expect_covered_at_least(covered(q, {.target = TargetError{.relative = relative}}),
                              q.name + " within " + std::to_string(relative));
    expect_covered_at_least(covered(q, {.samples_per_block = 16}), q.name);
  }
}

TEST(SampleCoverage, OfLightThroughAPinholeByATarget) {
  expect_covered_at_least(covered(pinhole(), {.target = TargetError{.relative = 1}}), "pinhole");
}

TEST(SampleCoverage, OfLightThroughAPinholeByACount) {
  for (const std::uint32_t each : {1U, 16U, 256U})
    expect_covered_at_least(covered(pinhole(), {.samples_per_block = each}),
                            std::to_string(each) + " samples a block");
}

TEST(SampleTarget, IsReached) {
  for (const Question& q : {lamp(), half_a_sky(), two_lamps()}) {
    int within = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      const Answered a = answer(q, {.target = TargetError{.relative = 0.02}}, i);
      within += std::fabs(luminance(a.estimate.irradiance_lx) - q.truth) <= 0.02 * q.truth;
    }
    EXPECT_GE(within, 367) << q.name;  // of 380, three standard deviations less
  }
}

TEST(SampleTarget, StopsAtTheLargestSampleCount) {
  Question q = lamp();
  q.scene = build(below_a_lid(0));
  TargetError target{.relative = 0.1, .max_samples = 1024};
  const Answered nothing = answer(q, {.target = target}, 0);
  EXPECT_EQ(nothing.samples, 1024U);
  EXPECT_EQ(luminance(nothing.estimate.irradiance_lx), 0);
  EXPECT_GT(nothing.estimate.illuminance_lx.upper, 0);
  // With an absolute floor above that bound.
  target.absolute_floor = 1;
  EXPECT_EQ(answer(q, {.target = target}, 0).samples, 64U);
}

}  // namespace
}  // namespace lucerna::testing

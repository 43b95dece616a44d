// Stop rules of EstimateIrradiance: a sample count, a target error, a time budget.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {
namespace {

class AccuracyTest : public ::testing::Test {
 protected:
  /// Three receivers below the lamp of the scene, and one that is NaN.
  v1::EstimateIrradianceRequest question() {
    auto q = about<v1::EstimateIrradianceRequest>(scene_);
    for (const float v :
         {0.0F, -2.0F, 0.5F, 1.0F, -2.5F, 0.7F, std::nanf(""), 0.0F, 0.0F, -1.0F, -3.0F, 1.0F})
      q.mutable_receivers()->add_offsets_m(v);
    for (int i = 0; i < 4; ++i)
      for (const float v : {0.0F, 0.0F, 1.0F}) q.add_normals(v);
    return q;
  }

  Service service_;
  const std::string scene_ = service_.load("bounces.pbrt");
};

TEST_F(AccuracyTest, ATargetErrorReportsIntervalsAndCostsOfEachItem) {
  v1::EstimateIrradianceRequest q = question();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.05);
  const auto r = service_.answer(q);
  ASSERT_EQ(r.lower_lx_size(), 4);
  ASSERT_EQ(r.item_costs().samples_size(), 4);
  std::uint32_t most = 0;
  for (int i = 0; i < 4; ++i) {
    const std::uint32_t samples = r.item_costs().samples(i);
    most = std::max(most, samples);
    if (i == 2) {
      EXPECT_EQ(r.status(i), v1::ITEM_STATUS_INVALID_INPUT);
      EXPECT_EQ(samples, 0U);
      EXPECT_EQ(r.upper_lx(i), 0);
      continue;
    }
    EXPECT_LT(r.lower_lx(i), r.illuminance_lx(i));
    EXPECT_LT(r.illuminance_lx(i), r.upper_lx(i));
    EXPECT_GT(r.item_costs().rays(i), samples);
    EXPECT_GT(r.item_costs().time_s(i), 0);
    // The same count gives the same bits.
    v1::EstimateIrradianceRequest again = q;
    again.mutable_accuracy()->set_samples(samples);
    const auto same = service_.answer(again);
    EXPECT_EQ(same.illuminance_lx(i), r.illuminance_lx(i));
    EXPECT_EQ(same.upper_lx(i), r.upper_lx(i));
    EXPECT_FALSE(same.has_item_costs());
  }
  EXPECT_EQ(r.samples(), most);
  // A smaller error or a higher confidence takes more samples.
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.01);
  const auto finer = service_.answer(q);
  EXPECT_GT(finer.item_costs().samples(0), 4 * r.item_costs().samples(0));
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.05);
  q.mutable_accuracy()->mutable_target_error()->set_confidence(0.999);
  const auto surer = service_.answer(q);
  EXPECT_GT(surer.item_costs().samples(0), r.item_costs().samples(0));
}

TEST_F(AccuracyTest, ATimeBudgetReportsItsSampleCount) {
  v1::EstimateIrradianceRequest q = question();
  for (const double budget : {1e-9, 0.05, 0.3}) {
    q.mutable_accuracy()->set_time_budget_s(budget);
    auto r = service_.answer(q);
    EXPECT_GE(r.samples(), 16U);
    EXPECT_EQ(r.samples() % 16, 0U);
    if (budget < 1e-6) {
      EXPECT_EQ(r.samples(), 16U);
    }
    v1::EstimateIrradianceRequest again = q;
    again.mutable_accuracy()->set_samples(r.samples());
    auto same = service_.answer(again);
    r.clear_cost(), same.clear_cost();
    EXPECT_EQ(r.SerializeAsString(), same.SerializeAsString()) << budget;
  }
}

TEST_F(AccuracyTest, ALongTimeBudgetEndsAtTheLargestSampleCount) {
  // One lamp that needs no sample: a run takes no time for any number of them.
  v1::EstimateIrradianceRequest q = question();
  q.set_scene_id(service_.load("point.pbrt"));
  q.set_bounces(0);
  q.mutable_accuracy()->set_time_budget_s(1e300);
  auto r = service_.answer(q);
  EXPECT_EQ(r.samples(), rpc::RequestLimits().max_samples);
  q.mutable_accuracy()->set_samples(r.samples());
  auto same = service_.answer(q);
  r.clear_cost(), same.clear_cost();
  EXPECT_EQ(r.SerializeAsString(), same.SerializeAsString());
}

TEST_F(AccuracyTest, AnySampleCountIsAccepted) {
  v1::EstimateIrradianceRequest q = question();
  for (const std::uint32_t n : {1U, 2U, 15U, 16U, 17U, 31U, 34U, 100U, 101U, 255U, 1000U}) {
    q.mutable_accuracy()->set_samples(n);
    const auto r = service_.answer(q);
    EXPECT_EQ(r.samples(), n);
    EXPECT_EQ(r.cost().samples(), 3 * n);
    EXPECT_EQ(r.lower_lx_size(), n > 1 ? 4 : 0) << n;
  }
}

TEST_F(AccuracyTest, InvalidSettingsAreNamed) {
  using Q = v1::EstimateIrradianceRequest;
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  std::vector<BadField<Q>> rows;
  const auto target = [&](const std::string& field, auto values, auto set) {
    for (const auto bad : values)
      rows.push_back({"accuracy.target_error." + field,
                      [=](Q& q) { (q.mutable_accuracy()->mutable_target_error()->*set)(bad); }});
  };
  using T = v1::TargetError;
  target("relative", std::vector{0.0, -1.0, nan, inf}, &T::set_relative);
  target("absolute_floor", std::vector{-1.0, nan, inf}, &T::set_absolute_floor);
  target("confidence", std::vector{0.0, 1.0, -0.5, 95.0, nan}, &T::set_confidence);
  target("max_samples", std::vector{0U, 63U, 4294967295U}, &T::set_max_samples);
  for (const double bad : {0.0, -1.0, nan, inf})
    rows.push_back(
        {"accuracy.time_budget_s", [=](Q& q) { q.mutable_accuracy()->set_time_budget_s(bad); }});
  Q valid = question();
  valid.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  expect_bad_fields(service_, valid, rows);
}

}  // namespace
}  // namespace lucerna::testing

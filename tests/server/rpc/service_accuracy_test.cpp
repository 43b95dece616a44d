// Stop rules of EstimateIrradiance: a sample count, a target error, a time budget.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/rpc/service_fixture.h"

namespace lucerna {
namespace {

class AccuracyTest : public ::testing::Test {
 protected:
  /// Three receivers below the lamp of the scene, and one that is NaN.
  v1::EstimateIrradianceRequest question() {
    v1::EstimateIrradianceRequest q;
    q.set_scene_id(scene_);
    for (const float v :
         {0.0F, -2.0F, 0.5F, 1.0F, -2.5F, 0.7F, std::nanf(""), 0.0F, 0.0F, -1.0F, -3.0F, 1.0F})
      q.mutable_receivers()->add_offsets_m(v);
    for (int i = 0; i < 4; ++i)
      for (const float v : {0.0F, 0.0F, 1.0F}) q.add_normals(v);
    return q;
  }
  grpc::Status estimate(const v1::EstimateIrradianceRequest& q, v1::EstimateIrradianceResponse* r) {
    r->Clear();
    return testing::status_of(
        [&](auto* c) { return service_.lighting.EstimateIrradiance(c, q, r); });
  }

  testing::Service service_;
  const std::string scene_ = service_.load("bounces.pbrt");
};

TEST_F(AccuracyTest, ATargetErrorReportsIntervalsAndCostsOfEachItem) {
  v1::EstimateIrradianceRequest q = question();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.05);
  v1::EstimateIrradianceResponse r;
  ASSERT_TRUE(estimate(q, &r).ok());
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
    v1::EstimateIrradianceResponse same;
    ASSERT_TRUE(estimate(again, &same).ok());
    EXPECT_EQ(same.illuminance_lx(i), r.illuminance_lx(i));
    EXPECT_EQ(same.upper_lx(i), r.upper_lx(i));
    EXPECT_FALSE(same.has_item_costs());
  }
  EXPECT_EQ(r.samples(), most);
  // A smaller error or a higher confidence takes more samples.
  v1::EstimateIrradianceResponse finer, surer;
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.01);
  ASSERT_TRUE(estimate(q, &finer).ok());
  EXPECT_GT(finer.item_costs().samples(0), 4 * r.item_costs().samples(0));
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.05);
  q.mutable_accuracy()->mutable_target_error()->set_confidence(0.999);
  ASSERT_TRUE(estimate(q, &surer).ok());
  EXPECT_GT(surer.item_costs().samples(0), r.item_costs().samples(0));
}

TEST_F(AccuracyTest, ATimeBudgetReportsItsSampleCount) {
  v1::EstimateIrradianceRequest q = question();
  for (const double budget : {1e-9, 0.05, 0.3}) {
    q.mutable_accuracy()->set_time_budget_s(budget);
    v1::EstimateIrradianceResponse r, same;
    ASSERT_TRUE(estimate(q, &r).ok());
    EXPECT_GE(r.samples(), 16U);
    EXPECT_EQ(r.samples() % 16, 0U);
    if (budget < 1e-6) {
      EXPECT_EQ(r.samples(), 16U);
    }
    v1::EstimateIrradianceRequest again = q;
    again.mutable_accuracy()->set_samples(r.samples());
    ASSERT_TRUE(estimate(again, &same).ok());
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
  v1::EstimateIrradianceResponse r, same;
  ASSERT_TRUE(estimate(q, &r).ok());
  EXPECT_EQ(r.samples(), rpc::RequestLimits().max_samples);
  q.mutable_accuracy()->set_samples(r.samples());
  ASSERT_TRUE(estimate(q, &same).ok());
  r.clear_cost(), same.clear_cost();
  EXPECT_EQ(r.SerializeAsString(), same.SerializeAsString());
}

TEST_F(AccuracyTest, AnySampleCountIsAccepted) {
  v1::EstimateIrradianceRequest q = question();
  for (const std::uint32_t n : {1U, 2U, 15U, 16U, 17U, 31U, 34U, 100U, 101U, 255U, 1000U}) {
    q.mutable_accuracy()->set_samples(n);
    v1::EstimateIrradianceResponse r;
    ASSERT_TRUE(estimate(q, &r).ok());
    EXPECT_EQ(r.samples(), n);
    EXPECT_EQ(r.cost().samples(), 3 * n);
    EXPECT_EQ(r.lower_lx_size(), n > 1 ? 4 : 0) << n;
  }
}

TEST_F(AccuracyTest, InvalidSettingsAreNamed) {
  const auto status_with = [&](auto&& change) {
    v1::EstimateIrradianceRequest q = question();
    change(*q.mutable_accuracy());
    v1::EstimateIrradianceResponse r;
    return estimate(q, &r);
  };
  using A = v1::Accuracy;
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, nan, inf}) {
    testing::expect_bad_field(
        status_with([&](A& a) { a.mutable_target_error()->set_relative(bad); }),
        "accuracy.target_error.relative");
    testing::expect_bad_field(status_with([&](A& a) { a.set_time_budget_s(bad); }),
                              "accuracy.time_budget_s");
  }
  const auto target = [&](auto&& change) {
    return status_with([&](A& a) {
      a.mutable_target_error()->set_relative(0.1);
      change(*a.mutable_target_error());
    });
  };
  for (const double bad : {-1.0, nan, inf})
    testing::expect_bad_field(target([&](v1::TargetError& t) { t.set_absolute_floor(bad); }),
                              "accuracy.target_error.absolute_floor");
  for (const double bad : {0.0, 1.0, -0.5, 95.0, nan})
    testing::expect_bad_field(target([&](v1::TargetError& t) { t.set_confidence(bad); }),
                              "accuracy.target_error.confidence");
  for (const std::uint32_t bad : {0U, 63U, 4294967295U})
    testing::expect_bad_field(target([&](v1::TargetError& t) { t.set_max_samples(bad); }),
                              "accuracy.target_error.max_samples");
}

}  // namespace
}  // namespace lucerna

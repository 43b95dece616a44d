// EstimatePower by sampling, for each kind of light.  Exact answers accept every stop rule.
#include <vector>

#include "every_light.h"
#include "every_query.h"

namespace lucerna::testing {
namespace {

class SampledPowerTest : public PowerTest {};

TEST_F(SampledPowerTest, IntervalsHoldTheExactPower) {
  const auto exact = answer(request(v1::EstimatePowerRequest::METHOD_EXACT));
  v1::EstimatePowerRequest q = request(v1::EstimatePowerRequest::METHOD_SAMPLED);
  // The interval of a light misses once in 1e8.
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.02);
  q.mutable_accuracy()->mutable_target_error()->set_confidence(1 - 1e-8);
  const auto rays = answer(q);
  ASSERT_EQ(rays.lights_size(), exact.lights_size());
  std::uint64_t samples = 0;
  for (int i = 0; i < exact.lights_size(); ++i) {
    const v1::LightPower &e = exact.lights(i), &r = rays.lights(i);
    EXPECT_EQ(r.light_id(), e.light_id());
    // Exact answers are off by roundings, also those of the flux that pictures hold in floats.
    const double slack = e.error_lm() + 1e-6 * e.power_lm();
    EXPECT_LE(r.lower_lm(), e.power_lm() + slack) << lights_.lights(i).ShortDebugString();
    EXPECT_GE(r.upper_lm(), e.power_lm() - slack) << lights_.lights(i).ShortDebugString();
    EXPECT_GE(r.samples(), 64U);
    EXPECT_EQ(r.error_lm(), 0);
    EXPECT_FALSE(e.has_upper_lm());
    EXPECT_FALSE(e.has_samples());
    samples += r.samples();
    // The same count gives the same bits.
    v1::EstimatePowerRequest again = q;
    again.add_light_ids(e.light_id());
    again.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(r.samples()));
    EXPECT_EQ(answer(again).lights(0).power_lm(), r.power_lm());
  }
  EXPECT_EQ(rays.total().samples(), samples);
  EXPECT_GT(rays.cost().samples(), samples);  // includes pilots
  EXPECT_LE(rays.total().lower_lm(), exact.total().power_lm());
  EXPECT_GE(rays.total().upper_lm(), exact.total().power_lm());
  EXPECT_GT(rays.total().standard_error_lm(), 0);
}

TEST_F(SampledPowerTest, StopsAtACountOrATimeAndDependsOnItsSeed) {
  v1::EstimatePowerRequest q = request(v1::EstimatePowerRequest::METHOD_SAMPLED);
  const auto by_default = answer(q);
  EXPECT_EQ(by_default.lights(0).samples(), 4096U);
  q.set_seed(7);
  EXPECT_NE(answer(q).total().power_lm(), by_default.total().power_lm());
  for (const std::uint32_t n : {1U, 2U, 15U, 100U}) {
    q.mutable_accuracy()->set_samples(n);
    const auto r = answer(q);
    EXPECT_EQ(r.lights(0).samples(), n);
    EXPECT_EQ(r.lights(0).has_upper_lm(), n > 1);
    EXPECT_EQ(r.lights(0).has_standard_error_lm(), n > 1);
  }
  for (const double budget : {1e-9, 0.1}) {
    q.mutable_accuracy()->set_time_budget_s(budget);
    const auto r = answer(q);
    const std::uint64_t n = r.lights(0).samples();
    EXPECT_GE(n, 16U);
    if (budget < 1e-6) {
      EXPECT_EQ(n, 16U);
    }
    v1::EstimatePowerRequest again = q;
    again.mutable_accuracy()->set_samples(static_cast<std::uint32_t>(n));
    EXPECT_EQ(answer(again).total().SerializeAsString(), r.total().SerializeAsString());
  }
  q.mutable_accuracy()->mutable_target_error()->set_relative(-1);
  expect_bad_field(service_.status(q), "accuracy.target_error.relative");
}

// Their answers are exact, so a stop rule has no effect.
TEST_F(SampledPowerTest, ExactAnswersAcceptAnyStopRule) {
  std::vector<v1::Accuracy> rules(3);
  rules[0].set_samples(5);
  rules[1].mutable_target_error()->set_relative(0.1);
  rules[2].set_time_budget_s(1);
  for (const v1::Accuracy& rule : rules) {
    for (const auto method :
         {v1::EstimatePowerRequest::METHOD_EXACT, v1::EstimatePowerRequest::METHOD_APPROXIMATE}) {
      v1::EstimatePowerRequest q = request(method), plain = q;
      *q.mutable_accuracy() = rule;
      EXPECT_EQ(answer(q).total().power_lm(), answer(plain).total().power_lm());
    }
    for_each_query(scene_, 4, [&]<typename Request>(Request q) {
      if constexpr (OneOf<Request, v1::SampleLeRequest, v1::PdfLeRequest, v1::PdfLiRequest,
                          v1::LeRequest, v1::TestVisibilityRequest>) {
        *q.mutable_accuracy() = rule;
        EXPECT_GT(service_.answer(q).ByteSizeLong(), 0U) << q.GetTypeName();
      }
    });
  }
}

}  // namespace
}  // namespace lucerna::testing

// SampleLi with a target error or a time budget: its sample counts and its estimates.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "proto/common/defaults.h"
#include "tests/server/rpc/service_fixture.h"

namespace lucerna::testing {
namespace {

double luminance_of(const float* rgb) {
  return 0.2126390058715104 * rgb[0] + 0.7151686787677559 * rgb[1] + 0.0721923153607337 * rgb[2];
}

bool bit(const std::string& bits, int i) {
  return (static_cast<unsigned char>(bits[static_cast<std::size_t>(i) / 8]) >> (i % 8) & 1) != 0;
}

class SampleAccuracy : public ::testing::Test {
 protected:
  /// Three receivers below the lamp of the scene, and one that is NaN.
  v1::SampleLiRequest question() {
    auto q = about<v1::SampleLiRequest>(scene_);
    for (const float v :
         {0.0F, -2.0F, 0.5F, 1.0F, -2.5F, 0.7F, std::nanf(""), 0.0F, 0.0F, -1.0F, -3.0F, 1.0F})
      q.mutable_receivers()->add_offsets_m(v);
    for (int i = 0; i < 4; ++i)
      for (const float v : {0.0F, 0.0F, 2.0F}) q.add_normals(v);
    q.mutable_seed()->set_seed(3);
    q.set_test_visibility(true);
    return q;
  }

  Service service_;
  const std::string scene_ = service_.load("bounces.pbrt");
};

/// The contribution of sample `i` by the formula of SampleLiResponse, facing up.  For a spectral
/// value, times that value over its luminance.
double share(const v1::SampleLiResponse& r, int i, double value) {
  const bool ok = r.status().empty() || r.status(i) == v1::ITEM_STATUS_OK;
  if (!ok || !bit(r.visible(), i)) return 0;
  const double density = bit(r.delta(), i) ? 1.0 : double{r.pdf_per_sr(i)};
  const double chosen = r.selection_probability().empty() ? 1 : r.selection_probability(i);
  return value * std::max(0.0F, r.wi(3 * i + 2)) / (density * chosen);
}

TEST_F(SampleAccuracy, EstimatesHaveTheMeanOfTheSamplesAndTheErrorOfTheirReplicates) {
  v1::SampleLiRequest q = question();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.03);
  q.add_wavelengths_nm(450);
  q.add_wavelengths_nm(600);
  const v1::SampleLiResponse r = service_.answer(q);
  const v1::ReceiverEstimates& e = r.estimates();
  ASSERT_EQ(e.samples_size(), 4);
  ASSERT_EQ(e.status_size(), 4);
  ASSERT_EQ(e.spectral_irradiance_size(), 8);
  int first = 0;
  for (int p = 0; p < 4; ++p) {
    const int n = static_cast<int>(e.samples(p));
    if (p == 2) {
      EXPECT_EQ(n, 1);
      EXPECT_EQ(e.status(p), v1::ITEM_STATUS_INVALID_INPUT);
      EXPECT_EQ(r.status(first), v1::ITEM_STATUS_INVALID_INPUT);
      EXPECT_EQ(e.upper_lx(p), 0);
      first += n;
      continue;
    }
    EXPECT_EQ(e.status(p), v1::ITEM_STATUS_OK);
    EXPECT_GE(n, 64);
    ASSERT_EQ(n % static_cast<int>(kDefaultBlocks), 0);
    // For illuminance and for two wavelengths.
    for (int k = 0; k < 3; ++k) {
      std::array<double, kDefaultBlocks> mean{};
      double sum = 0, squares = 0;
      for (int i = first; i < first + n; ++i) {
        const double value = k == 0 ? luminance_of(r.value().data() + 3 * i)
                                    : double{r.spectral_value(2 * i + k - 1)};
        mean[static_cast<std::size_t>(i - first) * kDefaultBlocks / n] +=
            share(r, i, value) * kDefaultBlocks / n;
      }
      for (const double m : mean) sum += m / kDefaultBlocks;
      for (const double m : mean) squares += (m - sum) * (m - sum);
      const double error = std::sqrt(squares / (kDefaultBlocks * (kDefaultBlocks - 1)));
      const double reported = k == 0 ? e.illuminance_lx(p) : e.spectral_irradiance(2 * p + k - 1);
      const double reported_error =
          k == 0 ? e.standard_error_lx(p) : e.spectral_standard_error(2 * p + k - 1);
      EXPECT_GT(sum, 0);
      EXPECT_NEAR(reported, sum, 1e-5 * sum) << p << " " << k;
      EXPECT_NEAR(reported_error, error, 1e-4 * error) << p << " " << k;
    }
    EXPECT_LT(e.lower_lx(p), e.illuminance_lx(p));
    EXPECT_LT(e.illuminance_lx(p), e.upper_lx(p));
    first += n;
  }
  EXPECT_EQ(r.pdf_per_sr_size(), first);
  // The pilot samples are included.
  EXPECT_GT(r.cost().samples(), static_cast<std::uint64_t>(first));
}

TEST_F(SampleAccuracy, LessErrorOrMoreConfidenceTakesMoreSamples) {
  v1::SampleLiRequest q = question();
  // Sampling by area.  By the cosine, samples of the lamp would be nearly equal.
  q.mutable_accuracy()->set_area_sampling(v1::AREA_SAMPLING_SQUARE_ROOT);
  v1::TargetError* target = q.mutable_accuracy()->mutable_target_error();
  const auto samples = [&](double relative, double confidence) {
    target->set_relative(relative);
    target->set_confidence(confidence);
    return service_.answer(q).estimates().samples(0);
  };
  const std::uint32_t coarse = samples(0.02, 0.95);
  EXPECT_GT(samples(0.001, 0.95), 4 * coarse);
  EXPECT_GT(samples(0.02, 0.9999), coarse);
}

TEST_F(SampleAccuracy, BatchesOfAnySizeHaveTheSameBits) {
  v1::SampleLiRequest q = question();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.02);
  q.mutable_accuracy()->mutable_target_error()->set_max_samples(8192);
  v1::SampleLiResponse whole = service_.answer(q), again = service_.answer(q);
  whole.clear_cost(), again.clear_cost();
  EXPECT_EQ(whole.SerializeAsString(), again.SerializeAsString());
  v1::SampleLiRequest last = q;
  last.mutable_receivers()->mutable_offsets_m()->ExtractSubrange(0, 9, nullptr);
  last.mutable_normals()->Truncate(3);
  last.mutable_seed()->set_first_item(3);
  const v1::SampleLiResponse alone = service_.answer(last);
  ASSERT_EQ(alone.estimates().samples_size(), 1);
  EXPECT_EQ(alone.estimates().samples(0), whole.estimates().samples(3));
  EXPECT_EQ(alone.estimates().illuminance_lx(0), whole.estimates().illuminance_lx(3));
  EXPECT_EQ(alone.wi(0), whole.wi(whole.wi_size() - alone.wi_size()));
}

TEST_F(SampleAccuracy, TheFirstReplicateHasTheSamplesOfAQueryForItsCount) {
  v1::SampleLiRequest q = question();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.02);
  const v1::SampleLiResponse r = service_.answer(q);
  const std::uint32_t each = r.estimates().samples(0) / kDefaultBlocks;
  q.mutable_accuracy()->set_samples(each);
  const v1::SampleLiResponse count = service_.answer(q);
  EXPECT_FALSE(count.has_estimates());
  for (int i = 0; i < static_cast<int>(3 * each); ++i) {
    EXPECT_EQ(count.wi(i), r.wi(i));
    EXPECT_EQ(count.value(i), r.value(i));
  }
}

TEST_F(SampleAccuracy, ADeltaLightTakesOneSample) {
  v1::SampleLiRequest q = question();
  q.set_scene_id(service_.load("point.pbrt"));
  q.clear_normals();
  const auto expect_exact = [&] {
    const v1::SampleLiResponse r = service_.answer(q);
    for (int p = 0; p < 4; ++p) {
      EXPECT_EQ(r.estimates().samples(p), 1U);
      EXPECT_EQ(r.estimates().standard_error_lx(p), 0);
      // Without a normal: all light that a surface facing the lamp would get.
      const double lux = luminance_of(r.value().data() + 3 * p);
      EXPECT_NEAR(r.estimates().illuminance_lx(p), lux, 1e-6 * lux);
      EXPECT_EQ(r.estimates().lower_lx(p), r.estimates().illuminance_lx(p));
      EXPECT_EQ(r.estimates().upper_lx(p), r.estimates().illuminance_lx(p));
      EXPECT_EQ(lux > 0, p != 2);
    }
    EXPECT_EQ(r.cost().samples(), 4U);
  };
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.01);
  expect_exact();
  q.set_light_id(1);
  expect_exact();
  q.mutable_accuracy()->set_time_budget_s(10);
  expect_exact();
}

TEST_F(SampleAccuracy, ATimeBudgetGivesEachReceiverEquallyManySamples) {
  v1::SampleLiRequest q = question();
  for (const double budget : {1e-9, 0.05, 1e300}) {
    q.mutable_accuracy()->set_time_budget_s(budget);
    const v1::SampleLiResponse r = service_.answer(q);
    const std::uint32_t n = r.estimates().samples(0);
    EXPECT_EQ(n % kDefaultBlocks, 0U);
    EXPECT_GE(n, kDefaultBlocks);
    EXPECT_EQ(r.estimates().samples(1), n);
    EXPECT_EQ(r.estimates().samples(2), 1U);
    EXPECT_EQ(r.estimates().samples(3), n);
    EXPECT_EQ(r.pdf_per_sr_size(), static_cast<int>(3 * n + 1));
    EXPECT_GT(r.estimates().upper_lx(0), r.estimates().lower_lx(0));
    if (budget < 1e-6) {
      EXPECT_EQ(n, kDefaultBlocks);
    }
    // At most the number that the batch may hold, for any time budget.
    EXPECT_LE(4 * n, rpc::RequestLimits().max_batch_items);
    if (budget > 1) {
      EXPECT_EQ(n, rpc::RequestLimits().max_batch_items / 4);
    }
  }
}

TEST_F(SampleAccuracy, EmptyRequestsHaveEmptyAnswers) {
  v1::SampleLiRequest q = question();
  q.mutable_receivers()->clear_offsets_m();
  q.clear_normals();
  q.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  EXPECT_EQ(service_.answer(q).pdf_per_sr_size(), 0);
  q.mutable_accuracy()->set_time_budget_s(0.01);
  EXPECT_EQ(service_.answer(q).estimates().samples_size(), 0);
}

TEST_F(SampleAccuracy, InvalidSettingsAreNamed) {
  v1::SampleLiRequest target = question();
  target.mutable_accuracy()->mutable_target_error()->set_relative(0.1);
  const auto time_and_values = [](auto& q) {
    q.mutable_accuracy()->set_time_budget_s(1);
    q.mutable_u();
  };
  const auto no_error = [](auto& q) {
    q.mutable_accuracy()->mutable_target_error()->set_relative(0);
  };
  const auto few_samples = [](auto& q) {
    q.mutable_accuracy()->mutable_target_error()->set_max_samples(63);
  };
  expect_bad_fields<v1::SampleLiRequest>(
      service_, target,
      {{"u", [](auto& q) { q.mutable_u()->add_u(0.5F); }},
       {"u", time_and_values},
       {"accuracy.target_error.relative", no_error},
       {"accuracy.target_error.max_samples", few_samples},
       {"accuracy.time_budget_s", [](auto& q) { q.mutable_accuracy()->set_time_budget_s(-1); }}});
  target.clear_seed();
  EXPECT_TRUE(service_.status(target).ok());  // seed 0
}

TEST_F(SampleAccuracy, TooLargeBatchesAreRefusedBeforehand) {
  const std::uint32_t most = rpc::RequestLimits().max_batch_items;
  const auto status_with = [&](std::uint32_t receivers, auto&& change) {
    v1::SampleLiRequest q = question();
    q.clear_normals();
    q.mutable_receivers()->mutable_offsets_m()->Resize(static_cast<int>(3 * receivers), 1);
    change(*q.mutable_accuracy());
    return service_.status(q);
  };
  using A = v1::Accuracy;
  const auto expect_refused = [&](const grpc::Status& s, const std::string& words) {
    expect_error(s, grpc::StatusCode::RESOURCE_EXHAUSTED, words);
    EXPECT_NE(s.error_message().find("limit of this server: " + std::to_string(most)),
              std::string::npos)
        << s.error_message();
  };
  const auto target = [](std::uint32_t samples) {
    return [samples](A& a) {
      a.mutable_target_error()->set_relative(100);
      if (samples > 0) a.mutable_target_error()->set_max_samples(samples);
    };
  };
  EXPECT_TRUE(status_with(4, target(most / 4)).ok());
  expect_refused(status_with(4, target(most / 4 + 1)), "accuracy.target_error.max_samples");
  EXPECT_TRUE(status_with(most / 64, target(0)).ok());
  expect_refused(status_with(most / 64 + 1, target(0)), "receivers times 64 samples");
  const auto time = [](A& a) { a.set_time_budget_s(1e-9); };
  EXPECT_TRUE(status_with(most / 16, time).ok());
  expect_refused(status_with(most / 16 + 1, time), "receivers times 16 samples");
}

}  // namespace
}  // namespace lucerna::testing

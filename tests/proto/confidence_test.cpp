// Intervals against sums whose distribution is known.
#include "proto/common/confidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lucerna {
namespace {

TEST(Confidence, OfManySamplesIsStudentsInterval) {
  // Quantiles of the tables: 2.131 for 15 degrees of freedom, 12.706 for one.
  const ConfidenceInterval many =
      IntervalRule(0.95, 16, 1024).interval({10, 0.1, 1024 * 101.0, 20});
  EXPECT_NEAR(many.lower, 10 - 0.21314, 1e-5);
  EXPECT_NEAR(many.upper, 10 + 0.21314, 1e-5);
  const ConfidenceInterval two = IntervalRule(0.95, 2, 1024).interval({10, 0.1, 1024 * 101.0, 20});
  EXPECT_NEAR(two.upper, 10 + 1.27062, 1e-5);
}

// Two-sided 5% and 0.1% points for 15 degrees of freedom.
TEST(Student, AgreesWithTheTable) {
  EXPECT_NEAR(student_p(2.13145, 15), 0.05, 1e-6);
  EXPECT_NEAR(student_p(-4.07277, 15), 0.001, 1e-7);
  EXPECT_NEAR(student_quantile(15, 0.025), 2.13145, 1e-5);
  EXPECT_NEAR(student_quantile(15, 0.0005), 4.07277, 1e-5);
}

TEST(Confidence, OfNoLightBoundsTheLightThatWasMissed) {
  const IntervalRule rule(0.95, 16, 1000);
  EXPECT_EQ(rule.interval({0, 0, 0, 0}).upper, 0);
  EXPECT_NEAR(rule.interval({0, 0, 0, 5}).upper, 2.9957 / 1000 * 5, 1e-6);
  EXPECT_EQ(rule.interval({0, 0, 0, 5}).lower, 0);
  // From two samples even that is unknown.
  EXPECT_EQ(IntervalRule(0.95, 2, 2).interval({0, 0, 0, 5}).upper, 5);
}

TEST(Confidence, OfRareEqualSamplesIsPoissonsInterval) {
  // 95% intervals for counts of 1, 5, 20, from the tables [Garwood36].
  struct Row {
    double count, lower, upper;
  };
  for (const Row& row : {Row{1, 0.0253, 5.572}, {5, 1.623, 11.668}, {20, 12.217, 30.888}}) {
    const double n = 1e6, weight = 3;
    // Replicates that agree by chance have no effect.
    const ConfidenceInterval i =
        IntervalRule(0.95, 16, 1000000)
            .interval({row.count * weight / n, 0, row.count * weight * weight, weight});
    EXPECT_NEAR(i.lower * n / weight, row.lower, 1e-3 * row.lower) << row.count;
    EXPECT_NEAR(i.upper * n / weight, row.upper, 1e-3 * row.upper) << row.count;
  }
}

// Each of 16 blocks has chosen a mirror in 2 of 8 samples, by a probability near 1/4.
TEST(Confidence, OfEqualReplicatesHasRoomForOneMoreSample) {
  constexpr double kFew = 1, kMany = 5;
  const double mean = (6 * kFew + 2 * kMany) / 8, squares = 6 * kFew * kFew + 2 * kMany * kMany;
  const ConfidenceInterval i =
      IntervalRule(0.95, 16, 128).interval({mean, 0, 128 * squares / 8, kMany});
  EXPECT_LE(i.lower, mean - 2.9957 * (kMany - kFew) / 128);
  EXPECT_GE(i.upper, mean + 2.9957 * (kMany - kFew) / 128);
  // Equal samples are exact.
  const ConfidenceInterval same = IntervalRule(0.95, 16, 128).interval({0.3, 0, 128 * 0.09, 0.3});
  EXPECT_DOUBLE_EQ(same.lower, 0.3);
  EXPECT_DOUBLE_EQ(same.upper, 0.3);
}

// A pixel of which `p` is lit, by 64 samples in 8 blocks.  All blocks have the same mean.
EstimateMoments edge(double p) {
  const double deviation = std::sqrt(p * (1 - p)), skewness = (1 - 2 * p) / deviation;
  return {.mean = p,
          .sum_of_squares = 64 * p,
          .largest = 1,
          .deviation = deviation,
          .skewness = skewness,
          .kurtosis = 1 + skewness * skewness};
}

TEST(Confidence, BesideAnEdgeIsTheRuleOfThree) {
  const IntervalRule rule(0.95, 8, 64);
  for (const double p : {0.3, 0.5, 0.9}) {
    // One sample more changes the mean by 1/64.
    const ConfidenceInterval i = rule.interval(edge(p));
    EXPECT_NEAR(i.upper, p + 2.9957 / 64, 1e-5);
    EXPECT_NEAR(i.lower, p - 2.9957 / 64, 1e-5);
  }
  // Evenly spread samples have a kurtosis of 1.8.
  EstimateMoments smooth = edge(0.5);
  smooth.kurtosis = 1.8;
  EXPECT_EQ(rule.interval(smooth).upper, 0.5);
  // Half of the rule: (1 + skewness^2) / kurtosis = 0.7.
  smooth.kurtosis = 1 / 0.7;
  EXPECT_NEAR(rule.interval(smooth).upper, 0.5 + 0.5 * 2.9957 / 64, 1e-5);
}

TEST(Confidence, OfSkewedSamplesReachesFartherUp) {
  EstimateMoments m{.mean = 10,
                    .standard_error = 0.1,
                    .sum_of_squares = 1024 * 101.0,
                    .largest = 20,
                    .deviation = 3.2,
                    .skewness = 6,
                    .kurtosis = 100};
  const ConfidenceInterval i = IntervalRule(0.95, 16, 1024).interval(m);
  // 2.1314 standard errors; skewness / sqrt(n) (2 t^2 + 1) / (6 t) = 0.14791.
  EXPECT_NEAR(i.lower, 10 - 0.21314, 1e-5);
  EXPECT_NEAR(i.upper, 10 + 0.21314 * 1.14786, 1e-4);
  m.skewness = -6;
  EXPECT_NEAR(IntervalRule(0.95, 16, 1024).interval(m).upper, 10 + 0.21314, 1e-5);
}

TEST(Confidence, OfOneReplicateIsInfinite) {
  const ConfidenceInterval i = IntervalRule(0.95, 1, 64).interval({1, 0, 64, 1});
  EXPECT_EQ(i.lower, 0);
  EXPECT_EQ(i.upper, std::numeric_limits<double>::infinity());
}

TEST(Confidence, IntervalsGrowWithTheConfidence) {
  double before = 0;
  for (const double confidence : {0.5, 0.9, 0.95, 0.99, 0.999}) {
    const ConfidenceInterval i =
        IntervalRule(confidence, 16, 1024).interval({10, 0.1, 1024 * 101.0, 20});
    EXPECT_GT(i.upper - i.lower, before);
    before = i.upper - i.lower;
  }
}

TEST(Confidence, IntervalsScaleWithTheSamples) {
  for (const double s : {1e-120, 1e-30, 1e30, 1e120}) {
    const ConfidenceInterval i =
        IntervalRule(0.95, 16, 1024).interval({s, 0.1 * s, 8 * s * s * 1024, 40 * s});
    const ConfidenceInterval one = IntervalRule(0.95, 16, 1024).interval({1, 0.1, 8 * 1024, 40});
    EXPECT_NEAR(i.lower / s, one.lower, 1e-12);
    EXPECT_NEAR(i.upper / s, one.upper, 1e-12);
  }
  // Squares that exceed doubles give no interval, but no crash either.
  const ConfidenceInterval i =
      IntervalRule(0.95, 16, 1024)
          .interval({1e200, 1e199, std::numeric_limits<double>::infinity(), 1e200});
  EXPECT_FALSE(i.upper < 1e200);
}

// Samples that a pixel filter weights: they may be negative.
TEST(Confidence, OfSignedSamplesMirrorsWithThem) {
  const IntervalRule rule(0.95, 8, 64);
  for (const double kurtosis : {2.5, 60.0}) {
    const EstimateMoments m{.mean = 0.3,
                            .standard_error = 0.05,
                            .sum_of_squares = 64 * (0.3 * 0.3 + 1),
                            .largest = 4,
                            .deviation = 1,
                            .skewness = 0.7,
                            .kurtosis = kurtosis,
                            .may_be_negative = true};
    EstimateMoments mirrored = m;
    mirrored.mean = -m.mean;
    mirrored.skewness = -m.skewness;
    const ConfidenceInterval a = rule.interval(m), b = rule.interval(mirrored);
    EXPECT_NEAR(a.lower, -b.upper, 1e-12) << kurtosis;
    EXPECT_NEAR(a.upper, -b.lower, 1e-12) << kurtosis;
    EXPECT_LT(a.lower, 0.3);
    EXPECT_LT(b.lower, 0);
  }
}

TEST(Confidence, OfNoSignedLightBoundsBothSigns) {
  const ConfidenceInterval i =
      IntervalRule(0.95, 16, 1000).interval({.largest = 5, .may_be_negative = true});
  EXPECT_NEAR(i.upper, 2.9957 / 1000 * 5, 1e-6);
  EXPECT_EQ(i.lower, -i.upper);
  const ConfidenceInterval one = IntervalRule(0.95, 1, 64)
                                     .interval({.mean = 1,
                                                .sum_of_squares = 64,
                                                .largest = 1,
                                                .kurtosis = 1,
                                                .may_be_negative = true});
  EXPECT_EQ(one.lower, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(one.upper, std::numeric_limits<double>::infinity());
}

// A flat field: the values are 1.2 and -1.2, and all blocks have the same mean.  One sample of
// the other sign changes the mean by 2.4 / 64; the rule of three allows for three of them.
TEST(Confidence, OfSignedSamplesIncludesOneMoreOfTheOtherSign) {
  const double mean = 1.05, deviation = std::sqrt(1.2 * 1.2 - mean * mean);
  const double p = (1 - mean / 1.2) / 2, skewness = (2 * p - 1) / std::sqrt(p * (1 - p));
  const ConfidenceInterval i = IntervalRule(0.95, 8, 64)
                                   .interval({.mean = mean,
                                              .sum_of_squares = 64 * 1.2 * 1.2,
                                              .largest = 1.2,
                                              .deviation = deviation,
                                              .skewness = skewness,
                                              .kurtosis = 1 + skewness * skewness,
                                              .may_be_negative = true});
  EXPECT_NEAR(i.upper - mean, 2.9957 * 2.4 / 64, 1e-4);
  EXPECT_NEAR(mean - i.lower, 2.9957 * 2.4 / 64, 1e-4);
}

}  // namespace
}  // namespace lucerna

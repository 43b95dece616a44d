// Intervals against sums whose distribution is known.
#include "server/estimate/statistics/confidence.h"

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

}  // namespace
}  // namespace lucerna

// Intervals, quartiles, curves and fronts, compared with results by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/tradeoff/study_statistics.h"

namespace lucerna::tradeoff {
namespace {

using ::testing::ElementsAre;

TEST(TradeoffStatistics, QuartilesLieBetweenSortedNumbers) {
  // Positions 1, 2 and 3 of 0 to 4; then 0.75, 1.5 and 2.25 of 0 to 3.
  const Quartiles five = quartiles({5, 1, 4, 2, 3});
  EXPECT_EQ(five.lower, 2);
  EXPECT_EQ(five.median, 3);
  EXPECT_EQ(five.upper, 4);
  const Quartiles four = quartiles({40, 10, 30, 20});
  EXPECT_DOUBLE_EQ(four.lower, 17.5);
  EXPECT_DOUBLE_EQ(four.median, 25);
  EXPECT_DOUBLE_EQ(four.upper, 32.5);
  const Quartiles one = quartiles({7});
  EXPECT_EQ(one.lower, 7);
  EXPECT_EQ(one.upper, 7);
}

TEST(TradeoffStatistics, MeanHasStudentsInterval) {
  // Mean 2, deviation 1, so the standard error is 1/sqrt(3); the table's t for two degrees of
  // freedom.
  const Interval i = mean_interval(std::vector<double>{1, 2, 3});
  const double factor = std::exp(4.302653 / std::sqrt(3.0) / 2);
  EXPECT_DOUBLE_EQ(i.mean, 2);
  EXPECT_NEAR(i.lower, 2 / factor, 1e-6);
  EXPECT_NEAR(i.upper, 2 * factor, 1e-5);
  const Interval root = root_mean_interval(std::vector<double>{1, 2, 3});
  EXPECT_DOUBLE_EQ(root.mean, std::sqrt(2));
  EXPECT_DOUBLE_EQ(root.lower, std::sqrt(i.lower));
}

TEST(TradeoffStatistics, EqualNumbersHaveAnEmptyIntervalAndOneNumberAnInfiniteOne) {
  const Interval same = mean_interval(std::vector<double>{0, 0, 0});
  EXPECT_EQ(same.lower, 0);
  EXPECT_EQ(same.upper, 0);
  const Interval single = mean_interval(std::vector<double>{3});
  EXPECT_EQ(single.mean, 3);
  EXPECT_EQ(single.lower, 0);
  EXPECT_TRUE(std::isinf(single.upper));
}

/// The number of 2000 intervals that hold the true value, 1.  Each interval is about `n` MSEs of
/// `items` normal errors.
int covered(int n, int items, double narrower) {
  std::mt19937_64 bits(1);
  std::normal_distribution<double> normal;
  int held = 0;
  for (int repeat = 0; repeat < 2000; ++repeat) {
    std::vector<double> squares(n);
    for (double& mse : squares) {
      for (int i = 0; i < items; ++i) mse += std::pow(normal(bits), 2) / items;
    }
    const Interval i = mean_interval(squares);
    held +=
        i.mean + (i.lower - i.mean) * narrower <= 1 && 1 <= i.mean + (i.upper - i.mean) * narrower;
  }
  return held;
}

// 95% of 2000 are 1900 with a deviation of 10.  The limit is five of these, and one percent for the
// logarithm.
TEST(TradeoffStatistics, IntervalsOfErrorsHoldTheTruth) {
  EXPECT_NEAR(covered(5, 100, 1), 1900, 70);
  EXPECT_LT(covered(5, 100, 0.5), 1800);
}

TEST(TradeoffStatistics, RateIsTheSlopeInLogarithms) {
  // error = 3 / sqrt(t).
  std::vector<Measured> curve;
  for (const double t : {0.01, 0.04, 0.2}) curve.push_back({t, 3 / std::sqrt(t), 100 * t});
  EXPECT_NEAR(fitted_rate(curve).value(), -0.5, 1e-12);
  EXPECT_FALSE(fitted_rate(std::span(curve).first(1)));
  curve[1].error = 0;
  EXPECT_FALSE(fitted_rate(curve));
}

TEST(TradeoffStatistics, TimeToErrorInterpolatesAndExtrapolatesByTheRootOfTime) {
  const std::vector<Measured> curve = {{4, 0.05, 400}, {1, 0.1, 100}, {16, 0.025, 1600}};
  const auto between = time_to_error(curve, 0.05 / std::sqrt(2));
  ASSERT_TRUE(between);
  EXPECT_EQ(between->how, Reached::How::kBetween);
  EXPECT_NEAR(between->seconds, 8, 1e-9);
  EXPECT_NEAR(between->samples, 800, 1e-9);
  const auto few = time_to_error(curve, 0.2);
  ASSERT_TRUE(few);
  EXPECT_EQ(few->how, Reached::How::kWithFewest);
  EXPECT_EQ(few->seconds, 1);
  const auto beyond = time_to_error(curve, 0.0125);
  ASSERT_TRUE(beyond);
  EXPECT_EQ(beyond->how, Reached::How::kExtrapolated);
  EXPECT_NEAR(beyond->seconds, 64, 1e-9);
  EXPECT_NEAR(beyond->samples, 6400, 1e-6);
  // No faster than that beyond them, because few measurements determine no rate.
  const auto fast = time_to_error({{1, 0.1, 100}, {4, 0.02, 400}, {16, 0.004, 1600}}, 0.002);
  ASSERT_TRUE(fast);
  EXPECT_NEAR(fast->seconds, 64, 1e-9);
  // Nearly equal times of a noisy machine do not change the samples.
  const auto noisy = time_to_error({{1, 0.1, 100}, {1 + 1e-9, 0.05, 400}}, 0.025);
  ASSERT_TRUE(noisy);
  EXPECT_NEAR(noisy->samples, 1600, 1e-6);
  EXPECT_FALSE(time_to_error(curve, 0.0125, false));
  EXPECT_FALSE(time_to_error(curve, 0.0001)) << "62500 times the longest measured time";
}

TEST(TradeoffStatistics, CurvesThatDoNotConvergeHaveNoTimeToError) {
  EXPECT_FALSE(time_to_error({{1, 0.1, 1}, {4, 0.099, 4}, {16, 0.1, 16}}, 0.01));
  EXPECT_FALSE(time_to_error({{1, 0.1, 1}, {4, 0.066, 4}, {16, 0.0435, 16}}, 0.01)) << "rate -0.3";
  EXPECT_FALSE(time_to_error({{1, 0.1, 1}}, 0.01));
  EXPECT_FALSE(time_to_error({}, 0.01));
}

TEST(TradeoffStatistics, ExactAnswersReachEveryError) {
  const auto exact = time_to_error({{1, 0.1, 1}, {4, 0, 4}}, 0.01);
  ASSERT_TRUE(exact);
  EXPECT_DOUBLE_EQ(exact->seconds, 4);
}

TEST(TradeoffStatistics, FrontHoldsOnlyUnbeatenPoints) {
  const std::vector<Measured> points = {{2, 0.5}, {1, 1},   {3, 0.6}, {2, 0.4},
                                        {4, 0.1}, {4, 0.1}, {5, 0.1}};
  EXPECT_THAT(pareto_front(points), ElementsAre(1, 3, 4));
  EXPECT_TRUE(pareto_front({}).empty());
}

}  // namespace
}  // namespace lucerna::tradeoff

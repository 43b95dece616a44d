// The tests of `lucerna verify` on samples whose density is known.  Random numbers have fixed
// seeds.
#include "client/lab/verify_statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/lab/partition.h"

namespace lucerna::verify {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;

/// Points of the unit square whose first coordinate has the density a x^(a - 1).
std::vector<Feature> features(std::mt19937_64& random, std::size_t n, double a) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Feature> all(n);
  for (Feature& f : all) {
    // In (0, 1], so that no density is 0.
    const double x = std::pow(1 - uniform(random), 1 / a);
    f = {x, uniform(random), 0, 0, 0, 0};
  }
  return all;
}

/// The p-value of `n` samples of the power `drawn`, which claim the power `claimed`, by a reference
/// of the power 1.
double p_value(std::mt19937_64& random, std::size_t n, double drawn, double claimed) {
  const std::vector<Feature> reference = features(random, 4 * n, 1);
  const Partition partition(reference, 16);
  std::vector<std::size_t> cells;
  std::vector<double> weights;
  for (const Feature& f : features(random, n, drawn)) {
    cells.push_back(partition.cell(f));
    weights.push_back(1 / (claimed * std::pow(f[0], claimed - 1)));
  }
  return cells_have_probabilities(partition, cells, weights, static_cast<double>(4 * n)).p.value();
}

TEST(VerifyPartition, CellsHoldEqualSharesOfTheReference) {
  std::mt19937_64 random(1);
  const Partition partition(features(random, 4096, 3), 16);
  ASSERT_EQ(partition.cells(), 16U);
  for (const double p : partition.probabilities()) EXPECT_EQ(p, 1.0 / 16);
}

TEST(VerifyPartition, SamplesThatCoincideShareACell) {
  // Three of four are equal, so only one cut is possible.
  const Partition partition({{0}, {0}, {0}, {1}}, 4);
  EXPECT_EQ(partition.cells(), 2U);
  EXPECT_THAT(partition.probabilities(), ElementsAre(0.75, 0.25));
  EXPECT_NE(partition.cell({0}), partition.cell({1}));
}

struct Claim {
  double power;
  const char* name;
};
class VerifyCells : public ::testing::TestWithParam<Claim> {};

// With a chance of a false alarm of 1% in each of 2000 runs, more than 48 alarms have a chance
// below 1e-6 (binomial).
TEST_P(VerifyCells, RightClaimsAreRejectedAtMostAtTheStatedLevel) {
  std::mt19937_64 random(7);
  int alarms = 0;
  for (int i = 0; i < 2000; ++i)
    alarms += p_value(random, 400, GetParam().power, GetParam().power) <= 0.01 ? 1 : 0;
  EXPECT_LE(alarms, 48);
}

TEST_P(VerifyCells, WrongClaimsAreRejected) {
  std::mt19937_64 random(8);
  EXPECT_LT(p_value(random, 4000, GetParam().power, GetParam().power + 0.3), 1e-6);
  EXPECT_LT(p_value(random, 4000, GetParam().power + 0.3, GetParam().power), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Powers, VerifyCells,
                         ::testing::Values(Claim{1, "AsTheReference"}, Claim{1.4, "Other"},
                                           Claim{0.7, "Peaked"}),
                         [](const auto& info) { return info.param.name; });

TEST(VerifyCells, TooFewSamplesAreNotJudged) {
  std::mt19937_64 random(2);
  const Partition partition(features(random, 64, 1), 4);
  EXPECT_FALSE(cells_have_probabilities(partition, {0, 1, 2, 3}, {1, 1, 1, 1}, 64).p);
}

TEST(VerifyCells, TheWorstCellIsNamed) {
  const Partition partition({{0}, {1}, {2}, {3}}, 4);
  std::vector<std::size_t> cells;
  for (std::size_t i = 0; i < 400; ++i) cells.push_back(i % 4);
  for (std::size_t i = 0; i < 100; ++i) cells.push_back(2);
  const TestResult test =
      cells_have_probabilities(partition, cells, std::vector<double>(500, 1), 1e9);
  EXPECT_EQ(test.worst_cell, 2U);
  // 200 of 500 where a quarter is expected.
  EXPECT_THAT(test.worst_ratio, DoubleNear(1.6, 1e-6));
  EXPECT_LT(test.p.value(), 1e-9);
}

// Without the correction for skewness, 0.6% of the runs are rejected.  At the level of 0.1% in each
// of 20000 runs, more than 48 alarms have a chance below 1e-6 (binomial).
TEST(VerifyMean, SkewedValuesAreRejectedAtMostAtTheStatedLevel) {
  // The squares of exponential numbers have the mean 2 and a long tail.
  std::mt19937_64 random(3);
  std::exponential_distribution<double> exponential(1);
  int alarms = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<double> values(400);
    for (double& v : values) v = std::pow(exponential(random), 2) / 2;
    alarms += mean_is(values, 1, 0).p.value_or(1) <= 0.001 ? 1 : 0;
  }
  EXPECT_LE(alarms, 48);
}

TEST(VerifyMean, AWrongMeanIsRejected) {
  std::mt19937_64 random(4);
  std::exponential_distribution<double> exponential(1);
  std::vector<double> values(4000);
  for (double& v : values) v = exponential(random);
  EXPECT_GT(mean_is(values, 1, 0).p.value(), 1e-3);
  EXPECT_LT(mean_is(values, 1.2, 0).p.value(), 1e-6);
  EXPECT_LT(mean_is(values, 0.8, 0).p.value(), 1e-6);
  // Rare values of 1, where a plain correction for skewness changes its sign.
  std::vector<double> rare(6400, 0);
  std::fill_n(rare.begin(), 400, 1);
  EXPECT_LT(mean_is(rare, 1, 0).p.value(), 1e-6);
}

TEST(VerifyMean, EqualValuesNeedNoScatter) {
  const std::vector<double> values(100, 1.0005);
  EXPECT_EQ(mean_is(values, 1, 1e-3).p, 1);
  EXPECT_EQ(mean_is(values, 1, 1e-4).p, 0);
}

TEST(VerifyMean, FewEffectiveValuesAreNotJudged) {
  std::vector<double> values(1000, 1e-3);
  values[0] = 1e3;
  EXPECT_FALSE(mean_is(values, 1, 0).p);
}

TEST(VerifyHolm, AdjustsAsInTheBook) {
  // Sorted: 0.01 * 4, 0.02 * 3, max(0.06, 0.03 * 2), max(0.06, 0.5).
  EXPECT_THAT(holm({0.03, 0.01, 0.5, 0.02}),
              ElementsAre(DoubleNear(0.06, 1e-12), DoubleNear(0.04, 1e-12), DoubleNear(0.5, 1e-12),
                          DoubleNear(0.06, 1e-12)));
  EXPECT_THAT(holm({0.9, 0.8}), ElementsAre(1, 1));
  EXPECT_THAT(holm({}), ElementsAre());
}

}  // namespace
}  // namespace lucerna::verify

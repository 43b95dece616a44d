#include "lights/sampling/sobol.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::chi_square_p_value;
using testing::RandomU;

/// Whether each elementary interval (a box of 2^-a by 2^-b, a + b = m) holds exactly one of the
/// first 2^m points.
bool is_stratified(int m, const std::function<Vec2f(std::uint32_t)>& point) {
  for (int a = 0; a <= m; ++a) {
    const int b = m - a;
    std::set<std::pair<int, int>> boxes;
    for (std::uint32_t i = 0; i < 1U << m; ++i) {
      const Vec2f p = point(i);
      boxes.emplace(int(std::ldexp(p.x, a)), int(std::ldexp(p.y, b)));
    }
    if (boxes.size() != 1U << m) return false;
  }
  return true;
}

TEST(SobolSequence, EveryElementaryIntervalOfAPrefixHoldsItsShare) {
  for (std::uint64_t item = 0; item < 40; ++item) {
    const SobolSequence points(7, item, item % 3);
    for (int m = 0; m <= 8; ++m) {
      for (const std::uint32_t pair : {0U, 1U, 17U, 0xFFFFFFFFU}) {
        EXPECT_TRUE(is_stratified(m, [&](std::uint32_t i) { return points.pair(i, pair); }))
            << "item " << item << ", 2^" << m << " points, pair " << pair;
      }
    }
  }
}

TEST(SobolSequence, EveryAlignedBlockIsStratifiedToo) {
  const SobolSequence points(1, 2, 3);
  for (const std::uint32_t block : {1U, 5U, 1000U, (1U << 26) - 1}) {
    EXPECT_TRUE(is_stratified(6, [&](std::uint32_t i) { return points.pair(block * 64 + i, 4); }));
  }
}

TEST(SobolSequence, IndependentRandomNumbersWouldFailTheStratificationTest) {
  for (int m = 2; m <= 8; ++m) {
    RandomU random(m);
    EXPECT_FALSE(is_stratified(m, [&](std::uint32_t) {
      return Vec2f{random.next(), random.next()};
    }));
  }
}

TEST(SobolSequence, PointsStayBelowOneAndAreMultiplesOfTwoToTheMinus24) {
  for (std::uint64_t item = 0; item < 1000; ++item) {
    const SobolSequence points(3, item);
    for (const std::uint32_t index : {0U, 1U, 77U, 0x80000000U, 0xFFFFFFFFU}) {
      const Vec2f p = points.pair(index, 0);
      for (const float u : {p.x, p.y}) {
        EXPECT_GE(u, 0);
        EXPECT_LT(u, 1);
        EXPECT_EQ(std::ldexp(u, 24), std::floor(std::ldexp(u, 24)));
      }
    }
  }
}

TEST(SobolSequence, IsAFunctionOfItsKeyAndIndexAlone) {
  EXPECT_EQ(SobolSequence(1, 2, 3).pair(4, 5), SobolSequence(1, 2, 3).pair(4, 5));
  const Vec2f p = SobolSequence(1, 2, 3).pair(4, 5);
  EXPECT_NE(p, SobolSequence(2, 2, 3).pair(4, 5));
  EXPECT_NE(p, SobolSequence(1, 3, 3).pair(4, 5));
  EXPECT_NE(p, SobolSequence(1, 2, 4).pair(4, 5));
  EXPECT_NE(p, SobolSequence(1, 2, 3).pair(5, 5));
  EXPECT_NE(p, SobolSequence(1, 2, 3).pair(4, 6));
  // The order of the parts and their sum both matter.
  EXPECT_NE(SobolSequence(1, 2).pair(0, 0), SobolSequence(2, 1).pair(0, 0));
  EXPECT_NE(SobolSequence(1, 2, 0).pair(0, 0), SobolSequence(1, 0, 2).pair(0, 0));
}

// 2^16 keys into 16 x 16 boxes.  Each rejects by chance with probability 1e-8.
TEST(SobolSequence, AnyPointIsEquidistributedOverKeys) {
  constexpr int kKeys = 1 << 16;
  for (const std::uint32_t index : {0U, 1U, 6U, 0x12345678U}) {
    std::vector<double> over_items(256), over_seeds(256), over_replicates(256);
    const auto count = [&](std::vector<double>& bins, const SobolSequence& points) {
      const Vec2f p = points.pair(index, 2);
      ++bins[int(p.x * 16) * 16 + int(p.y * 16)];
    };
    for (std::uint64_t i = 0; i < kKeys; ++i) {
      count(over_items, SobolSequence(1, i));
      count(over_seeds, SobolSequence(i, 1));
      count(over_replicates, SobolSequence(1, 1, i));
    }
    const std::vector<double> expected(256, kKeys / 256.);
    EXPECT_GT(chi_square_p_value(over_items, expected), 1e-8) << index;
    EXPECT_GT(chi_square_p_value(over_seeds, expected), 1e-8) << index;
    EXPECT_GT(chi_square_p_value(over_replicates, expected), 1e-8) << index;
  }
}

/// The mistake of a broken hash: the key is added to a fixed sequence.
TEST(SobolSequence, EquidistributionTestRejectsAKeyThatOnlyShifts) {
  std::vector<double> bins(256);
  for (int i = 0; i < 1 << 16; ++i) ++bins[int(std::fmod(i * 0.618, 1) * 16) * 16 + i % 7];
  EXPECT_LT(chi_square_p_value(bins, std::vector<double>(256, 256.)), 1e-8);
}

// Means of 16 stratified points have the mean 1/2.  The variance of a mean in one dimension is that
// of 16 strata with one uniform point each: (1/12) / 16^3.  Over 20000 keys, two bounds are
// exceeded less than once in 1e7 each.  For the mean of means it is 5.5 standard errors, and for
// their variance (kurtosis near 3) 5.5 sqrt(2 / n).
TEST(SobolSequence, MeansOverKeysHaveTheMeanAndVarianceOfStratifiedPoints) {
  constexpr int kKeys = 20000, kPoints = 16;
  double sum = 0, sum2 = 0;
  for (int key = 0; key < kKeys; ++key) {
    const SobolSequence points(9, key);
    double mean = 0;
    for (int i = 0; i < kPoints; ++i) mean += double{points.pair(i, 1).y} / kPoints;
    sum += mean - 0.5;
    sum2 += (mean - 0.5) * (mean - 0.5);
  }
  const double variance = 1 / 12. / std::pow(kPoints, 3);
  EXPECT_NEAR(sum / kKeys, 0, 5.5 * std::sqrt(variance / kKeys));
  EXPECT_NEAR(sum2 / kKeys / variance, 1, 5.5 * std::sqrt(2. / kKeys));
}

/// Correlation over n points, in standard errors (1 / sqrt(n) for independent numbers).
template <typename A, typename B>
double correlation_in_errors(int n, A&& a, B&& b) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += (a(i) - 0.5) * (b(i) - 0.5) * 12;
  return sum / std::sqrt(n);
}

// Each over the first points of 2^16 keys.  5.5 standard errors are exceeded by chance less than
// once in 1e7.
TEST(SobolSequence, DimensionsPairsItemsAndReplicatesAreUncorrelated) {
  constexpr int kKeys = 1 << 16;
  const auto at = [](int key, int item, int block, int pair, int index) {
    return SobolSequence(key, item, block).pair(index, pair);
  };
  const auto base = [&](int i) { return at(i, 0, 0, 0, 3).x; };
  EXPECT_LT(
      std::fabs(correlation_in_errors(kKeys, base, [&](int i) { return at(i, 0, 0, 0, 3).y; })),
      5.5);
  EXPECT_LT(
      std::fabs(correlation_in_errors(kKeys, base, [&](int i) { return at(i, 0, 0, 1, 3).x; })),
      5.5);
  EXPECT_LT(
      std::fabs(correlation_in_errors(kKeys, base, [&](int i) { return at(i, 1, 0, 0, 3).x; })),
      5.5);
  EXPECT_LT(
      std::fabs(correlation_in_errors(kKeys, base, [&](int i) { return at(i, 0, 1, 0, 3).x; })),
      5.5);
  EXPECT_LT(
      std::fabs(correlation_in_errors(kKeys, base, [&](int i) { return at(i + 1, 0, 0, 0, 3).x; })),
      5.5);
  EXPECT_GT(correlation_in_errors(kKeys, base, base), 100);
}

// Within one key too: the shuffled order pairs the points of two pairs at random.  So products of
// one pair with another converge.  64 points, 1000 keys.
TEST(SobolSequence, PairsOfOneKeyAreShuffledAgainstEachOther) {
  constexpr int kKeys = 1000, kPoints = 64;
  double square = 0, same = 0;
  for (int key = 0; key < kKeys; ++key) {
    const SobolSequence points(5, key);
    const double r = correlation_in_errors(
        kPoints, [&](int i) { return points.pair(i, 0).x; },
        [&](int i) { return points.pair(i, 1).x; });
    square += r * r / kKeys;
    same += std::fabs(r) > 6;
  }
  EXPECT_EQ(same, 0);
  // Ideal nested scrambling, with a hash for every flip, gives 1.574 +- 0.007 (simulated once with
  // 10^5 keys).  That exceeds 1 because it moves points in pairs.  With the same order it would be
  // 64.  The mean of 1000 squares has a standard error of 0.07; the bounds are 5.5 of them.
  EXPECT_NEAR(square, 1.574, 0.385);
}

TEST(MixBits, FlipsHalfOfTheBitsForEachBitOfInput) {
  // 64 x 64 x 1000 flips, each of standard deviation 0.5 / sqrt(1000); the bound is 6.5 of them.
  constexpr int kInputs = 1000;
  for (int bit = 0; bit < 64; ++bit) {
    std::array<int, 64> flips{};
    for (std::uint64_t i = 0; i < kInputs; ++i) {
      const std::uint64_t input = (i + 1) * 0x9E3779B97F4A7C15U;
      const std::uint64_t changed = mix_bits(input) ^ mix_bits(input ^ (std::uint64_t{1} << bit));
      for (int out = 0; out < 64; ++out) flips[out] += int(changed >> out & 1);
    }
    for (const int f : flips) EXPECT_NEAR(f / double{kInputs}, 0.5, 6.5 * 0.5 / std::sqrt(kInputs));
  }
}

}  // namespace
}  // namespace lucerna

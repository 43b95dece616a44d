#include "proto/common/luminance_moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace lucerna {
namespace {

constexpr std::size_t kBlock = 8;

std::vector<double> samples(std::size_t blocks) {
  std::mt19937 random(3);
  std::lognormal_distribution<double> distribution(0, 1.5);
  std::vector<double> v(blocks * kBlock);
  for (double& x : v) x = distribution(random);
  return v;
}

LuminanceMoments block(const std::vector<double>& v, std::size_t b) {
  BlockMoments moments;
  double sum = 0;
  for (std::size_t i = b * kBlock; i < (b + 1) * kBlock; ++i) {
    moments.add(v[i], v[i]);
    sum += v[i];
  }
  return moments.result(sum / kBlock);
}

LuminanceMoments run(const std::vector<double>& v, std::size_t first, std::size_t blocks) {
  BlockMerger<LuminanceMoments> merger(first, 1);
  for (std::size_t b = first; b < first + blocks; ++b) EXPECT_TRUE(merger.add(b, 1, {block(v, b)}));
  return merger.total()[0];
}

/// The sum over all samples of (sample - mean)^k, divided by the samples of a block.
double central(const std::vector<double>& v, int k) {
  long double mean = 0, sum = 0;
  for (const double x : v) mean += x;
  mean /= static_cast<long double>(v.size());
  for (const double x : v) sum += std::pow(x - mean, k);
  return static_cast<double>(sum / kBlock);
}

TEST(LuminanceMoments, AreThoseOfAllSamples) {
  // A large offset, too: nothing may cancel.
  for (const double offset : {0.0, 1e6}) {
    std::vector<double> v = samples(24);
    for (double& x : v) x += offset;
    const LuminanceMoments m = run(v, 0, 24);
    EXPECT_NEAR(m.second, central(v, 2), 1e-8 * central(v, 2));
    EXPECT_NEAR(m.third, central(v, 3), 1e-8 * central(v, 3));
    EXPECT_NEAR(m.fourth, central(v, 4), 1e-8 * central(v, 4));
    EXPECT_EQ(m.largest, *std::max_element(v.begin(), v.end()));
    EXPECT_FALSE(m.partly_hidden);
    const EstimateMoments e = estimate_moments(m, 24, v.size());
    const double deviation = std::sqrt(central(v, 2) / 24);
    EXPECT_NEAR(e.deviation, deviation, 1e-8 * deviation);
    EXPECT_NEAR(e.skewness, central(v, 3) / 24 / std::pow(deviation, 3), 1e-6);
    EXPECT_NEAR(e.kurtosis, central(v, 4) / 24 / std::pow(deviation, 4), 1e-6);
    double squares = 0;
    for (const double x : v) squares += x * x;
    EXPECT_NEAR(e.sum_of_squares, squares, 1e-12 * squares);
  }
}

TEST(LuminanceMoments, HaveTheSameBitsForAnySplit) {
  const std::vector<double> v = samples(16);
  const std::string whole = bytes_of(std::vector{run(v, 0, 16)});
  EXPECT_EQ(whole.size(), kMomentBytes);
  for (const std::size_t each : {1U, 2U, 4U, 8U}) {
    BlockMerger<LuminanceMoments> merger(0, 1);
    for (std::size_t b = 0; b < 16; b += each)
      // Through the plane of a tile.
      ASSERT_TRUE(merger.add(b, each, moments_of(bytes_of(std::vector{run(v, b, each)}))));
    EXPECT_EQ(bytes_of(merger.total()), whole) << each;
  }
}

TEST(LuminanceMoments, KnowThatSomethingWasHidden) {
  BlockMoments moments;
  moments.add(1, 1);
  EXPECT_FALSE(moments.result(1).partly_hidden);
  moments.add(0, 5);
  const LuminanceMoments m = moments.result(0.5);
  EXPECT_TRUE(m.partly_hidden);
  EXPECT_EQ(m.largest, 5);
  EXPECT_TRUE(merge({}, 1, m, 1).partly_hidden);
}

TEST(LuminanceMoments, OfLargeNumbersStayFinite) {
  for (const double value : {1e38, 1e300, std::numeric_limits<double>::infinity()}) {
    BlockMoments moments;
    for (const double v : {value, 0.0, value / 3}) moments.add(v, v);
    const LuminanceMoments m = merge(moments.result(1e38), 1, {}, 1);
    for (const double v : {m.second, m.third, m.fourth, m.largest})
      EXPECT_TRUE(std::isfinite(v)) << value;
  }
}

TEST(LuminanceMoments, KnowWhetherSamplesMayBeNegative) {
  for (const bool hidden : {false, true}) {
    BlockMoments moments(true);
    moments.add(-2, hidden ? 3 : 2);
    const LuminanceMoments m = moments_of(bytes_of(std::vector{moments.result(-2)}))[0];
    EXPECT_TRUE(m.may_be_negative);
    EXPECT_EQ(m.partly_hidden, hidden);
    EXPECT_EQ(m.largest, hidden ? 3 : 2);
    EXPECT_TRUE(merge(m, 1, m, 1).may_be_negative);
  }
  EXPECT_FALSE(moments_of(bytes_of(std::vector{BlockMoments().result(0)}))[0].may_be_negative);
}

TEST(PixelIntervals, AreRoundedOutwards) {
  const double third = 1.0 / 3;
  const FloatInterval i = rounded_outwards({third, 2 * third});
  EXPECT_LT(i.lower, third);
  EXPECT_GT(i.upper, 2 * third);
  EXPECT_EQ(std::nextafter(i.lower, 1.0F), static_cast<float>(third));
  // Unknown, and too large for a float.
  constexpr float kLargest = std::numeric_limits<float>::max();
  for (const double upper : {1e39, std::numeric_limits<double>::infinity(), std::nan("")})
    EXPECT_EQ(rounded_outwards({-1, upper}).upper, kLargest);
  EXPECT_EQ(rounded_outwards({-1, 1}).lower, 0);
  EXPECT_EQ(rounded_outwards({std::nan(""), 1}).lower, 0);
  EXPECT_EQ(rounded_outwards({std::nan(""), 1}, least_value(true)).lower, -kLargest);
  EXPECT_LE(rounded_outwards({-third, 1}, least_value(true)).lower, -third);
}

TEST(PixelIntervals, OfOneBlockAreUnknownUnlessAllIsBlack) {
  BlockMoments lit, black;
  lit.add(2, 2);
  black.add(0, 0);
  const std::vector moments{lit.result(2), black.result(0)};
  const std::vector<FloatInterval> i = pixel_intervals(moments, 1, 1);
  EXPECT_EQ(i[0].lower, 0);
  EXPECT_EQ(i[0].upper, std::numeric_limits<float>::max());
  EXPECT_EQ(i[1].upper, 0);
}

}  // namespace
}  // namespace lucerna

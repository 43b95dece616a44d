#include "proto/common/quantile.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace lucerna {
namespace {

TEST(Quantile, IsTheNearestRank) {
  std::vector<float> values(1000);
  std::iota(values.begin(), values.end(), 1.0F);
  std::shuffle(values.begin(), values.end(), std::mt19937(1));
  EXPECT_EQ(quantile(values, 0.5), 500);
  EXPECT_EQ(quantile(values, 0.9), 900);
  EXPECT_EQ(quantile(values, 0.99), 990);
  EXPECT_EQ(quantile(values, 0.999), 999);
  EXPECT_EQ(quantile(values, 1), 1000);
  EXPECT_EQ(quantile(values, 1e-9), 1);
  EXPECT_EQ(quantile(values, 0), 1);
}

TEST(Quantile, OfFewValuesIsOneOfThem) {
  const std::vector<double> none, one = {3}, four = {4, 1, 3, 2};
  EXPECT_EQ(quantile(none, 0.5), 0);
  EXPECT_EQ(quantile(one, 0.5), 3);
  EXPECT_EQ(quantile(one, 0.999), 3);
  EXPECT_EQ(median(four), 2);
  EXPECT_EQ(quantile(four, 0.51), 3);
}

}  // namespace
}  // namespace lucerna

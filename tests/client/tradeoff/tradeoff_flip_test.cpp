// FLIP of pictures with known values.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "client/tradeoff/flip.h"

namespace lucerna::tradeoff {
namespace {

constexpr std::uint32_t kWidth = 48, kHeight = 40;
using Colour = std::array<float, 3>;

std::vector<float> plain(const Colour& colour) {
  std::vector<float> rgb;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i)
    rgb.insert(rgb.end(), colour.begin(), colour.end());
  return rgb;
}
std::vector<float> flip_of(const std::vector<float>& a, const std::vector<float>& b) {
  return flip(a, b, kWidth, kHeight);
}
void expect_everywhere(const std::vector<float>& values, double value) {
  ASSERT_EQ(values.size(), kWidth * kHeight);
  for (const float v : values) ASSERT_NEAR(v, value, 1e-4);
}

TEST(Flip, EqualPicturesDoNotDiffer) {
  std::vector<float> rgb = plain({0.2F, 0.5F, 0.1F});
  for (std::size_t i = 0; i < rgb.size(); i += 7) rgb[i] = 0.9F;
  expect_everywhere(flip_of(rgb, rgb), 0);
}

// Between uniform pictures only colour counts.  Green and blue have the largest difference by
// definition.  L* of black and white differs by 100, and the largest difference is 203.3
// [Andersson20].  Then (100 / 203.3)^0.7 = 0.6088, and the value is 0.95 + (0.6088 - 0.4) / 0.6 x
// 0.05.
TEST(Flip, PlainPicturesDifferByTheirColour) {
  expect_everywhere(flip_of(plain({0, 1, 0}), plain({0, 0, 1})), 1);
  expect_everywhere(flip_of(plain({0, 0, 0}), plain({1, 1, 1})), 0.96740);
  // L* = 50 is a luminance of ((50 + 16) / 116)^3.
  const auto grey = static_cast<float>(std::pow(66.0 / 116, 3));
  const double share = std::pow(50 / 203.3, 0.7);
  expect_everywhere(flip_of(plain({0, 0, 0}), plain({grey, grey, grey})), share * 0.95 / 0.4);
}

TEST(Flip, ColoursBeyondTheScreenDoNotDiffer) {
  expect_everywhere(flip_of(plain({1, 1, 1}), plain({7, 2, 1})), 0);
  expect_everywhere(flip_of(plain({-1, 0, std::nanf("")}), plain({0, 0, 0})), 0);
}

// A missing point is a difference in features at the point and in colour about it.  Beyond three
// deviations of the widest Gaussian, 10 pixels, there is none.  Both orders are equal.
TEST(Flip, APointDiffersAtItsPlace) {
  const std::vector<float> dark = plain({0.05F, 0.05F, 0.05F});
  std::vector<float> point = dark;
  const std::size_t at = (std::size_t{20} * kWidth + 24);
  for (int c = 0; c < 3; ++c) point[3 * at + c] = 1;
  const std::vector<float> seen = flip_of(dark, point), other = flip_of(point, dark);
  EXPECT_EQ(seen, other);
  EXPECT_EQ(std::max_element(seen.begin(), seen.end()) - seen.begin(), at);
  EXPECT_GT(seen[at], 0.3F);
  EXPECT_EQ(seen[at - 20], 0);
  EXPECT_EQ(seen[at - 3], seen[at + 3]);
  EXPECT_EQ(seen[at - 3 * kWidth], seen[at + 3 * kWidth]);
}

// White from column 24 on, against black.  The weights of a derivative of a Gaussian sum to 1 for
// each sign.  So the derivative is 1 there and the exponent 1 - 2^-1/4 = 0.1591.  The filter of
// luminance, with a deviation of 1.034 pixels, gives a pixel the weight 0.386.  Column 24 has 0.693
// of white, L* = 86.65, and column 23 has 0.307, 62.25.  From colour alone they would be (86.65 /
// 203.3)^0.7 = 0.5504, which gives 0.9625, and 0.9531.
TEST(Flip, EdgeCountsMoreThanItsColours) {
  const std::vector<float> black = plain({0, 0, 0});
  std::vector<float> step = black;
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = i / 3 % kWidth < 24 ? 0 : 1;
  const std::vector<float> seen = flip_of(black, step);
  const float* row = &seen[std::size_t{20} * kWidth];
  EXPECT_NEAR(row[24], std::pow(0.9625, 0.1591), 3e-4);
  EXPECT_NEAR(row[23], std::pow(0.9531, 0.1591), 3e-4);
  EXPECT_NEAR(row[45], 0.9674, 1e-4);
  EXPECT_EQ(row[5], 0);
}

// Compares with the same formulas without the separation of filters and sums: in numpy, with each
// filter as one square of weights.
TEST(Flip, AgreesWithFiltersThatAreNotSeparated) {
  const auto picture = [](std::uint32_t k) {
    std::vector<float> rgb;
    for (std::uint32_t y = 0; y < kHeight; ++y) {
      for (std::uint32_t x = 0; x < kWidth; ++x) {
        for (std::uint32_t c = 0; c < 3; ++c)
          rgb.push_back(static_cast<float>((x * 7 + y * 13 + c * 5 + k * x * y) % 17) / 16);
      }
    }
    return rgb;
  };
  const std::vector<float> seen = flip_of(picture(0), picture(1));
  EXPECT_NEAR(seen[0], 0.0657893, 1e-6);
  EXPECT_NEAR(seen[20 * kWidth + 24], 0.1813712, 1e-6);
  EXPECT_NEAR(seen.back(), 0.2736534, 1e-6);
  EXPECT_NEAR(std::accumulate(seen.begin(), seen.end(), 0.0) / seen.size(), 0.3599121, 1e-6);
}

// From farther away there are more pixels per degree, and single wrong pixels are less visible.
TEST(Flip, DistanceBlursNoise) {
  const std::vector<float> grey = plain({0.4F, 0.4F, 0.4F});
  std::vector<float> noisy = grey;
  for (std::size_t i = 0; i < noisy.size() / 3; ++i)
    for (int c = 0; c < 3; ++c) noisy[3 * i + c] = (i + i / kWidth) % 2 == 0 ? 0.3F : 0.5F;
  const auto mean = [](const std::vector<float>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  const double near = mean(flip(grey, noisy, kWidth, kHeight, 20));
  const double far = mean(flip(grey, noisy, kWidth, kHeight, 67));
  EXPECT_GT(near, 2 * far);
}

}  // namespace
}  // namespace lucerna::tradeoff

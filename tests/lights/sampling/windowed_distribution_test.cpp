#include "lights/sampling/windowed_distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/lights/contract/emission_checks.h"

namespace lucerna {
namespace {

using testing::RandomU;
using Window = WindowedDistribution::Window;

constexpr int kSize = 8;

std::vector<double> weights() {
  RandomU random(1);
  std::vector<double> w;
  for (int i = 0; i < kSize * kSize; ++i) w.push_back(i % 5 == 0 ? 0 : random.next() + 0.1);
  return w;
}

/// From the definition: the share of each cell that the window covers, times its weight.
double weight_in(const std::vector<double>& w, const Window& window) {
  const auto covered = [](int cell, double begin, double extent) {
    return std::max(0.0, std::min((cell + 1.0) / kSize, begin + extent) -
                             std::max(double(cell) / kSize, begin)) *
           kSize;
  };
  double sum = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      sum += w[static_cast<std::size_t>(y * kSize + x)] * covered(x, window.x, window.width) *
             covered(y, window.y, window.height);
  return sum;
}

Window eighths(double x, double y, double width, double height) {
  return {x / 8, y / 8, width / 8, height / 8};
}

/// All kinds: the whole square, on cells' edges, within one cell, one row, one column, across many.
/// Cells begin at multiples of 1/320 of each window, so the midpoint rule below is exact.
const std::vector<Window> kWindows{
    {},
    eighths(1, 2, 4, 1),
    eighths(2.5, 3.25, 0.4, 0.5),
    eighths(0.5, 1.25, 5, 1),
    eighths(3.6, 1.5, 0.08, 5),
    eighths(1.6, 0.75, 4, 5),
    eighths(0, 0, 1.6, 1.6),
    eighths(7.2, 5.6, 0.8, 2),
};

TEST(WindowedDistribution, DensityIsTheWeightOverThatOfTheWindowAndASixteenthUniform) {
  const std::vector<double> w = weights();
  const WindowedDistribution table(kSize, w);
  RandomU random(2);
  for (const Window& window : kWindows) {
    const double total = weight_in(w, window);
    for (int i = 0; i < 200; ++i) {
      const Vec2 u = random.pair();
      const Vec2 at{window.x + u.x * window.width, window.y + u.y * window.height};
      const auto cell = [](double c) { return std::min(int(c * kSize), kSize - 1); };
      const double by_weight =
          w[static_cast<std::size_t>(cell(at.y) * kSize + cell(at.x))] * kSize * kSize / total;
      const double expected = 15.0 / 16 * by_weight + 1.0 / 16 / (window.width * window.height);
      // Weights are multiples of 2^-40 of the largest.
      EXPECT_NEAR(table.pdf(window, at), expected, 1e-9 * expected);
    }
  }
}

TEST(WindowedDistribution, SamplesFollowTheDensityWithinTheWindow) {
  const WindowedDistribution table(kSize, weights());
  for (const Window& window : kWindows) {
    RandomU random(3);
    const auto verdict = testing::check_follows_on_square(
        [&]() -> std::optional<Vec2> {
          const auto s = table.sample(window, random.pair());
          EXPECT_NEAR(s.pdf, table.pdf(window, s.position), 1e-12 * s.pdf);
          return Vec2{(s.position.x - window.x) / window.width,
                      (s.position.y - window.y) / window.height};
        },
        [&](double x, double y) {
          return table.pdf(window, {window.x + x * window.width, window.y + y * window.height}) *
                 (window.width * window.height);
        });
    EXPECT_TRUE(verdict.ok()) << verdict.failure << " in a window of " << window.width << " x "
                              << window.height;
  }
}

TEST(WindowedDistribution, TestRejectsAWrongWindow) {
  // The companion of the test above: the density of another window.
  const WindowedDistribution table(kSize, weights());
  RandomU random(3);
  const Window window = kWindows[5];
  const auto verdict = testing::check_follows_on_square(
      [&]() -> std::optional<Vec2> {
        const auto s = table.sample(window, random.pair());
        return Vec2{(s.position.x - window.x) / window.width,
                    (s.position.y - window.y) / window.height};
      },
      [&](double x, double y) {
        return table.pdf({}, {window.x + x * window.width, window.y + y * window.height}) *
               (window.width * window.height);
      });
  EXPECT_FALSE(verdict.ok());
}

TEST(WindowedDistribution, SmallWindowsBesideABrightCellLoseNothing) {
  // 1e-12 of the largest weight, in a window without that weight: it must have no effect.
  std::vector<double> w(64 * 64, 1);
  w[0] = 1e12;
  for (int i = 32 * 64; i < 64 * 64; ++i) w[static_cast<std::size_t>(i)] = i % 2 == 0 ? 3 : 1;
  const WindowedDistribution table(64, w);
  const Window window{0.25, 0.75, 0.5, 0.125};  // 32 x 8 cells, half of them 3
  // Weights below 2^-40 of the largest are rounded up to it: 1e-12 is 1.1 of that.
  const double threes = table.pdf(window, {0.25 + 0.5 / 64, 0.8}) * window.width * window.height;
  const double ones = table.pdf(window, {0.25 + 1.5 / 64, 0.8}) * window.width * window.height;
  EXPECT_NEAR(threes + ones, 2, 1e-12);
  EXPECT_GT(threes, 1.3);
  const Window tiny{0.3, 0.8, 1e-9, 1e-13};
  const auto s = table.sample(tiny, {0.9, 0.1});
  EXPECT_NEAR(s.pdf * 1e-22, 1, 1e-12);
  EXPECT_GE(s.position.x, 0.3);
  EXPECT_LE(s.position.x, 0.3 + 1e-9);
}

TEST(WindowedDistribution, TheEndsOfTheUnitSquareGivePointsOfTheWindow) {
  const WindowedDistribution table(kSize, weights());
  for (const Window& window : kWindows)
    for (const double x : {0.0, 1.0 / 16, 1 - 0x1p-24, 1.0})
      for (const double y : {0.0, 1 - 0x1p-24, 1.0}) {
        const auto s = table.sample(window, {x, y});
        EXPECT_TRUE(s.pdf > 0 && std::isfinite(s.pdf));
        EXPECT_GE(s.position.x, window.x);
        EXPECT_LE(s.position.x, window.x + window.width * (1 + 1e-12));
        EXPECT_GE(s.position.y, window.y);
        EXPECT_LE(s.position.y, window.y + window.height * (1 + 1e-12));
      }
}

TEST(WindowedDistribution, WithoutWeightItIsUniform) {
  const WindowedDistribution table(4, std::vector<double>(16));
  EXPECT_NEAR(table.pdf({0.1, 0.2, 0.5, 0.25}, {0.3, 0.3}), 8, 1e-12);
}

}  // namespace
}  // namespace lucerna

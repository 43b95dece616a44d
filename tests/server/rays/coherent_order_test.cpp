#include "server/rays/coherent_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <random>

namespace lucerna {
namespace {

std::vector<Vec3f> random_points(std::size_t n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-3, 5);
  std::vector<Vec3f> points(n);
  for (Vec3f& p : points) p = {uniform(random), uniform(random), uniform(random)};
  return points;
}

bool has_each_once(std::vector<std::uint32_t> order, std::size_t n) {
  std::ranges::sort(order);
  for (std::size_t i = 0; i < order.size(); ++i)
    if (order[i] != i) return false;
  return order.size() == n;
}

std::vector<std::uint32_t> given_order(std::size_t n) {
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  return order;
}

double mean_step(const std::vector<Vec3f>& points, const std::vector<std::uint32_t>& order) {
  double sum = 0;
  for (std::size_t k = 1; k < order.size(); ++k)
    sum += length(points[order[k]] - points[order[k - 1]]);
  return sum / static_cast<double>(order.size() - 1);
}

TEST(CoherentOrder, HoldsEachRayOnceAndNeighboursNear) {
  const auto points = random_points(16'384);
  const auto order = coherent_order(points), given = given_order(points.size());
  EXPECT_TRUE(has_each_once(order, points.size()));
  EXPECT_LT(mean_step(points, order), 0.2 * mean_step(points, given));
}

TEST(CoherentOrder, KeepsOrdersThatAreAsGood) {
  std::vector<Vec3f> rows;
  for (int i = 0; i < 4096; ++i)
    rows.push_back({static_cast<float>(i % 64), static_cast<float>(i / 64), 2});
  EXPECT_TRUE(coherent_order(rows).empty());
  EXPECT_TRUE(coherent_order(random_points(100)).empty());
}

TEST(CoherentOrder, TakesAnyNumbers) {
  using Limits = std::numeric_limits<float>;
  constexpr std::array<float, 6> kOdd{Limits::quiet_NaN(), Limits::infinity(),
                                      -Limits::infinity(), Limits::max(),
                                      -Limits::max(),      Limits::denorm_min()};
  // The box has the extent of all floats, an ordinary one, or none.
  for (const std::size_t kinds : {std::size_t{6}, std::size_t{3}, std::size_t{1}}) {
    auto points = random_points(1024);
    for (std::size_t i = 0; i < points.size(); i += 3) points[i].x = kOdd.at(i % kinds);
    const auto order = coherent_order(points);
    if (!order.empty()) {
      EXPECT_TRUE(has_each_once(order, points.size()));
    }
  }
  EXPECT_TRUE(coherent_order(std::vector<Vec3f>(1024, {1, 2, 3})).empty());
}

}  // namespace
}  // namespace lucerna

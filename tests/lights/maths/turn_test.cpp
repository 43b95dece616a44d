#include "lights/maths/turn.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lucerna {
namespace {

constexpr double kBound = 0x1p-52;

/// The largest error over `count` equal steps of a turn.  The angle has 64 digits, so its rounding
/// does not count.
template <typename F>
double worst_error(int count, const F& of_turn) {
  long double worst = 0;
  for (int i = 0; i <= count; ++i) {
    const double share = static_cast<double>(i) / count;
    const long double angle = 2 * std::numbers::pi_v<long double> * share;
    const CosSin found = of_turn(share);
    worst = std::fmax(worst, std::fabs(found.cos - std::cos(angle)));
    worst = std::fmax(worst, std::fabs(found.sin - std::sin(angle)));
  }
  return static_cast<double>(worst);
}

TEST(Turn, CosineAndSineAreWithinTheirBound) {
  EXPECT_LE(worst_error(100'003, cos_sin_of_turn), kBound);
}

// An angle that is rounded before its quarter is removed.
TEST(Turn, ARoundedAngleExceedsTheBound) {
  const auto rounded = [](double share) {
    const double angle = 2 * std::numbers::pi * share;
    return CosSin{std::cos(angle), std::sin(angle)};
  };
  EXPECT_GT(worst_error(100'003, rounded), kBound);
}

TEST(Turn, QuartersAreExact) {
  const double cosines[] = {1, 0, -1, 0, 1}, sines[] = {0, 1, 0, -1, 0};
  for (int quarter = 0; quarter <= 4; ++quarter) {
    const CosSin found = cos_sin_of_turn(quarter / 4.0);
    EXPECT_EQ(found.cos, cosines[quarter]) << quarter;
    EXPECT_EQ(found.sin, sines[quarter]) << quarter;
  }
}

}  // namespace
}  // namespace lucerna

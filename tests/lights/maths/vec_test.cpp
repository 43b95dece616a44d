#include "lights/maths/vec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lights/maths/density.h"
#include "lights/maths/rgb.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using V = Vec3f;

TEST(Vec3, ArithmeticIsComponentwise) {
  EXPECT_EQ(V(1, 2, 3) + V(10, 20, 30), V(11, 22, 33));
  EXPECT_EQ(V(1, 2, 3) - V(10, 20, 30), V(-9, -18, -27));
  EXPECT_EQ(-V(1, -2, 3), V(-1, 2, -3));
  EXPECT_EQ(2.F * V(1, 2, 3) / 4.F, V(0.5F, 1, 1.5F));
  EXPECT_EQ(V(4, 5, 6)[0] * 100 + V(4, 5, 6)[1] * 10 + V(4, 5, 6)[2], 456);
}

TEST(Vec3, CrossOfXAndYIsZ) {
  EXPECT_EQ(cross(V(1, 0, 0), V(0, 1, 0)), V(0, 0, 1));
  EXPECT_EQ(cross(V(0, 1, 0), V(0, 0, 1)), V(1, 0, 0));
  EXPECT_EQ(dot(V(1, 2, 3), V(4, -5, 6)), 12);
}

TEST(Vec3, LengthIsAccurateWhereSquaresLeaveTheRange) {
  EXPECT_EQ(length(V(3, 4, 0)), 5);
  EXPECT_EQ(length(V(0, 0, 0)), 0);
  for (const double s : {1e-38, 1e-30, 1e-20, 1e20, 6e37}) {
    const auto f = static_cast<float>(s);
    EXPECT_FLOAT_EQ(length(V(2 * f, -1 * f, 2 * f)), 3 * f);
  }
  for (const double s : {1e-300, 1e-200, 1e200, 1e307}) {
    EXPECT_DOUBLE_EQ(length(Vec3(2 * s, -1 * s, 2 * s)), 3 * s);
  }
}

// Equals scaling each number by std::scalbn, also where results are subnormal or exceed doubles.
TEST(Vec3, ScalingIsByPowersOfTwoAtEveryMagnitude) {
  for (const int of : {-1074, -1060, -1023, -1022, -537, -1, 0, 1, 511, 1000, 1023}) {
    const double x = std::scalbn(of < -1022 ? 1 : 1.37, of);
    EXPECT_EQ(exponent_of(x), std::ilogb(x));
    for (const int by : {-2200, -1074, -1023, -1022, -600, -1, 0, 1, 537, 1023, 1024, 2046, 2200}) {
      const Vec3 v = scaled(Vec3{x, -x / 3, 0}, by);
      EXPECT_EQ(v, (Vec3{std::scalbn(x, by), std::scalbn(-x / 3, by), 0})) << of << by;
      EXPECT_EQ(scaled(x, by), std::scalbn(x, by)) << of << by;
    }
  }
}

TEST(Vec3, LargestComponentIgnoresNaN) {
  EXPECT_EQ(max_abs(V(1, -3, 2)), 3);
  EXPECT_EQ(max_abs(V(-0.0F, 0, 0)), 0);
  for (const V& v : {V(NAN, 2, -3), V(2, NAN, -3), V(-3, 2, NAN), V(NAN, NAN, 3), V(3, NAN, NAN)})
    EXPECT_EQ(max_abs(v), 3) << v.x << " " << v.y << " " << v.z;
  EXPECT_EQ(max_abs(V(NAN, -INFINITY, 3)), INFINITY);
  EXPECT_EQ(max_abs(V(NAN, NAN, NAN)), 0);
}

TEST(Vec3, IsFiniteIfAllComponentsAre) {
  constexpr float kMax = std::numeric_limits<float>::max(), kInf = INFINITY;
  for (const V& v : {V(1, -3, 2), V(0, 0, 0), V(kMax, kMax, 0), V(-kMax, -kMax, -kMax)})
    EXPECT_TRUE(is_finite(v)) << v.x << " " << v.y << " " << v.z;
  for (const V& v : {V(kInf, 0, 0), V(0, -kInf, 0), V(0, 0, NAN), V(kInf, -kInf, 0),
                     V(kMax, kMax, kInf), V(-kMax, -kMax, NAN)})
    EXPECT_FALSE(is_finite(v)) << v.x << " " << v.y << " " << v.z;
}

TEST(Vec3, LengthOfNonFiniteVectorsIsNotFinite) {
  EXPECT_FALSE(std::isfinite(length(V(NAN, 0, 0))));
  EXPECT_FALSE(std::isfinite(length(V(1, 0, INFINITY))));
  EXPECT_FALSE(std::isfinite(length(Vec3(0, NAN, 0))));
  EXPECT_FALSE(std::isfinite(length(Vec3(1, NAN, -INFINITY))));
}

template <typename Real>
class NormalizedTest : public ::testing::Test {};
using Reals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(NormalizedTest, Reals);

TYPED_TEST(NormalizedTest, HasUnitLengthAndTheSameBitsAtEveryScale) {
  using Real = TypeParam;
  const BasicVec3<Real> v(Real(0.3), Real(-1.7), Real(2.9));
  const BasicVec3<Real> n = normalized(v);
  EXPECT_NEAR(length(n), 1, 2 * std::numeric_limits<Real>::epsilon());
  EXPECT_NEAR(n.z / n.x, v.z / v.x, 40 * std::numeric_limits<Real>::epsilon());
  const int largest = std::numeric_limits<Real>::max_exponent - 4;
  for (const int k : {-largest, -70, -3, 1, 65, largest}) {
    EXPECT_EQ(normalized(scaled(v, k)), n) << k;
    EXPECT_EQ(length(scaled(v, k)), std::scalbn(length(v), k)) << k;
  }
}

TYPED_TEST(NormalizedTest, KeepsZeroAndPropagatesNaN) {
  using Real = TypeParam;
  EXPECT_EQ(normalized(BasicVec3<Real>()), BasicVec3<Real>());
  EXPECT_FALSE(is_finite(normalized(BasicVec3<Real>(1, Real(INFINITY), 0))));
  EXPECT_FALSE(is_finite(normalized(BasicVec3<Real>(1, Real(NAN), 0))));
}

TEST(Frame, IsOrthonormalAndRightHandedForEveryNormal) {
  testing::RandomU random(8);
  const auto check = [](const V& n) {
    const auto f = Framef::around(n);
    EXPECT_EQ(f.n, n);
    EXPECT_NEAR(length(f.s), 1, 1e-6);
    EXPECT_NEAR(length(f.t), 1, 1e-6);
    EXPECT_NEAR(dot(f.s, f.t), 0, 1e-6);
    EXPECT_NEAR(dot(f.s, f.n), 0, 1e-6);
    EXPECT_NEAR(dot(f.t, f.n), 0, 1e-6);
    EXPECT_NEAR(length(cross(f.s, f.t) - f.n), 0, 1e-6);
    const V v(0.1F, 0.2F, 0.3F);
    EXPECT_NEAR(length(f.local_from_world(f.world_from_local(v)) - v), 0, 1e-6);
  };
  for (int i = 0; i < 1000; ++i) check(V(testing::Region{}.at(random.next(), random.next())));
  for (const V& n : {V(0, 0, 1), V(0, 0, -1), V(1, 0, 0.F), V(1, 0, -0.F), V(0, -1, 0)}) check(n);
  check(normalized(V(1e-4F, 1e-4F, -1)));
}

[[gnu::noinline]] Vec3 from_rounded(const Vec3& at, const Vec3f& to) {
  return Vec3(to) - Vec3(Vec3f(at));
}

// Results are reported as floats of doubles, and used as inputs again.
TEST(Vec3, RoundingToFloatsIsNotOptimisedAway) {
  volatile double x = 1.1;  // unknown to the compiler
  volatile float rounded = 1.1F;
  EXPECT_EQ(from_rounded({x, x, x}, {rounded, rounded, rounded}), Vec3());
}

// Rec. 709: white of (1, 1, 1) has luminance 1; green weighs most.
TEST(Rgb, LuminanceOfWhiteIsOne) {
  EXPECT_DOUBLE_EQ(luminance(Rgb(1)), 1);
  EXPECT_NEAR(luminance(Rgb(0, 1, 0)), 0.7152, 5e-5);
  EXPECT_NEAR(luminance(Rgb(1, 0, 0)), 0.2126, 5e-5);
}

// A square metre that faces the receiver at 2 m covers 1/4 sr, so the density is 4 / sr.  Turned by
// 60 degrees it is 8 / sr.
TEST(Density, AreaToSolidAngleDividesByTheCosineOverDistanceSquared) {
  EXPECT_EQ(to_solid_angle(AreaPdf{1}, 2., 1.).per_sr, 4);
  EXPECT_EQ(to_solid_angle(AreaPdf{1}, 2., 0.5).per_sr, 8);
  EXPECT_EQ(to_solid_angle(AreaPdf{1}, 2, 0).per_sr, INFINITY);
  // d^2 = 1e400 does not fit a double; the density does.
  EXPECT_DOUBLE_EQ(to_solid_angle(AreaPdf{1e-200}, 1e200, 1).per_sr, 1e200);
}

}  // namespace
}  // namespace lucerna

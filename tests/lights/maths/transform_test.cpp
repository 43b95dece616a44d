#include "lights/maths/transform.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lights/maths/vec.h"

namespace lucerna {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// A few roundings of an entry, times coordinates that sum to about 10.
void expect_near(const Vec3& a, const Vec3& b, double tolerance = 4e-15) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Transform, IdentityKeepsPointsVectorsAndNormals) {
  const Vec3 v{1, -2, 3};
  EXPECT_EQ(Transform().point(v), v);
  EXPECT_EQ(Transform().vector(v), v);
  EXPECT_EQ(Transform().normal(v), v);
}

TEST(Transform, TranslationMovesPointsOnly) {
  const Transform t = Transform::translate({1, 2, 3});
  EXPECT_EQ(t.point({10, 10, 10}), Vec3(11, 12, 13));
  EXPECT_EQ(t.vector({10, 10, 10}), Vec3(10, 10, 10));
  EXPECT_EQ(t.normal({10, 10, 10}), Vec3(10, 10, 10));
  EXPECT_EQ(t.inverse().point({11, 12, 13}), Vec3(10, 10, 10));
}

TEST(Transform, RotationIsCounterClockwiseSeenAgainstTheAxis) {
  expect_near(Transform::rotate(kPi / 2, {0, 0, 5})->point({1, 0, 0}), {0, 1, 0});
  expect_near(Transform::rotate(kPi / 2, {1e-30, 0, 0})->point({0, 1, 0}), {0, 0, 1});
  expect_near(Transform::rotate(kPi / 2, {0, 2, 0})->point({0, 0, 1}), {1, 0, 0});
  // A third of a turn about the diagonal takes each axis to the next.
  expect_near(Transform::rotate(2 * kPi / 3, {1, 1, 1})->point({1, 2, 3}), {3, 1, 2});
}

TEST(Transform, ProductAppliesTheRightFactorFirst) {
  const Transform t = Transform::translate({1, 0, 0}) * *Transform::rotate(kPi / 2, {0, 0, 1});
  expect_near(t.point({1, 0, 0}), {1, 1, 0});
  expect_near(t.inverse().point({1, 1, 0}), {1, 0, 0});
}

TEST(Transform, LookAtIsPbrtsCameraFrame) {
  // From the origin along +z with +y up, camera and world are the same.
  expect_near(Transform::look_at({0, 0, 0}, {0, 0, 7}, {0, 3, 0})->point({1, 2, 3}), {1, 2, 3});
  // Looking along +x, +z up.  The camera's z is world x and its y is world z.  Its x = y cross z is
  // world y, which pbrt's left-handed frame shows on the right.
  const Transform t = *Transform::look_at({10, 0, 0}, {11, 0, 0}, {0.5, 0, 1});
  expect_near(t.point({0, 0, 2}), {12, 0, 0});
  expect_near(t.vector({0, 1, 0}), {0, 0, 1});
  expect_near(t.vector({1, 0, 0}), {0, 1, 0});
  EXPECT_FALSE(t.swaps_handedness());
}

TEST(Transform, LookAtRefusesInputsWithoutAFrame) {
  EXPECT_FALSE(Transform::look_at({1, 2, 3}, {1, 2, 3}, {0, 1, 0}));
  EXPECT_FALSE(Transform::look_at({0, 0, 0}, {0.1, 0.2, 0.3}, {0.3, 0.6, 0.9}));
  EXPECT_FALSE(Transform::look_at({0, 0, 0}, {0, 0, 1}, {0, 0, 0}));
  EXPECT_FALSE(Transform::look_at({0, kNan, 0}, {0, 0, 1}, {0, 1, 0}));
}

TEST(Transform, SingularAndNonFiniteMatricesHaveNoInverse) {
  EXPECT_FALSE(Transform::scale({1, 0, 1}));
  EXPECT_FALSE(Transform::scale({1, kInf, 1}));
  EXPECT_FALSE(Transform::scale({1, kNan, 1}));
  // The rank is two, but rounding makes the determinant about 1e-16 instead of 0.
  EXPECT_FALSE(
      Transform::from_matrix({{{0.1, 0.2, 0.3, 0}, {0.4, 0.5, 0.6, 0}, {0.7, 0.8, 0.9, 0}}}));
  EXPECT_FALSE(Transform::from_matrix({{{1, 0, 0, kInf}, {0, 1, 0, 0}, {0, 0, 1, 0}}}));
  EXPECT_FALSE(Transform::rotate(1, {0, 0, 0}));
  EXPECT_FALSE(Transform::rotate(kInf, {0, 0, 1}));
}

TEST(Transform, ExtremeScalesAreInverted) {
  for (const double s : {1e-200, 1e-30, 1e30, 1e200}) {
    const auto t = Transform::scale({s, s, s});
    ASSERT_TRUE(t) << s;
    EXPECT_DOUBLE_EQ(t->inverse().vector({s, 0, 0}).x, 1);
    EXPECT_EQ(t->uniform_scale(), s);
    const auto uneven = Transform::scale({s, 1, 1 / s});
    ASSERT_TRUE(uneven) << s;
    expect_near(uneven->inverse().point(uneven->point({1, 2, 3})), {1, 2, 3});
  }
}

TEST(Transform, InverseUndoesAGeneralMatrix) {
  const auto t = Transform::from_matrix({{{2, 1, -3, 4}, {0.5, 5, 1, -6}, {1, -1, 2, 9}}});
  ASSERT_TRUE(t);
  expect_near(t->inverse().point(t->point({3, -4, 5})), {3, -4, 5}, 1e-14);
  expect_near(t->point(t->inverse().point({3, -4, 5})), {3, -4, 5}, 1e-14);
}

TEST(Transform, NormalsStayPerpendicularToTheirSurface) {
  const auto t = Transform::from_matrix({{{2, 1, -3, 4}, {0.5, 5, 1, -6}, {1, -1, 2, 9}}});
  ASSERT_TRUE(t);
  const Vec3 a{1, 2, 3}, b{-2, 0.5, 1};
  const Vec3 n = t->normal(cross(a, b));
  EXPECT_NEAR(dot(n, t->vector(a)), 0, 1e-14);
  EXPECT_NEAR(dot(n, t->vector(b)), 0, 1e-14);
  EXPECT_GT(length(n), 0.1);
}

TEST(Transform, MirrorsSwapHandedness) {
  EXPECT_TRUE(Transform::scale({-1, 1, 1})->swaps_handedness());
  EXPECT_TRUE(Transform::scale({-1e-150, -1e-150, -1e-150})->swaps_handedness());
  EXPECT_FALSE(Transform::scale({-2, -3, 1})->swaps_handedness());
  EXPECT_FALSE(Transform::rotate(3, {1, 2, 3})->swaps_handedness());
}

TEST(Transform, UniformScaleExistsOnlyForEqualFactors) {
  const Transform turn = *Transform::rotate(1, {1, 2, 3});
  EXPECT_EQ(Transform::scale({0.1, 0.1, -0.1})->uniform_scale(), 0.1);
  EXPECT_NEAR((turn * *Transform::scale({4, 4, 4})).uniform_scale().value_or(0), 4, 1e-14);
  EXPECT_TRUE(Transform::scale({1, 1, 1 + 1e-7})->uniform_scale());
  EXPECT_FALSE(Transform::scale({1, 1, 1 + 1e-5})->uniform_scale());
  // A shear whose columns are all of length 1.
  EXPECT_FALSE(
      Transform::from_matrix({{{1, 0.6, 0, 0}, {0, 0.8, 0, 0}, {0, 0, 1, 0}}})->uniform_scale());
}

}  // namespace
}  // namespace lucerna

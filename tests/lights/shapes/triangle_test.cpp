#include "lights/shapes/triangle.h"

#include <gtest/gtest.h>

#include "tests/lights/area_helpers.h"
#include "tests/lights/shapes/shape_helpers.h"

namespace lucerna::testing {
namespace {

/// Barycentric coordinates (of b and of c) in the triangle a = 0, b = (2, 0, 1), c = (0, 4, 0).
const Triangle kSkewed{{0, 0, 0}, {2, 0, 1}, {0, 4, 0}};
TEST(Triangle, AreaAndNormalFollowFromTheCrossProduct) {
  // (2, 0, 1) x (0, 4, 0) = (-4, 0, 8), of length sqrt(80).
  EXPECT_DOUBLE_EQ(kSkewed.area(), std::sqrt(20.0));
  const Vec3 n = kSkewed.normal();
  EXPECT_DOUBLE_EQ(n.x, -1 / std::sqrt(5.0));
  EXPECT_EQ(n.y, 0);
  EXPECT_DOUBLE_EQ(n.z, 2 / std::sqrt(5.0));
}

TEST(Triangle, AreaOfTinyHugeAndNeedleTrianglesIsExact) {
  for (const float s : {1e-23, 1.0, 1e19}) {
    const Triangle t{{0, 0, 0}, {s, 0, 0}, {0, s, 0}};
    EXPECT_NEAR(t.area() / (0.5 * double{s} * s), 1, 1e-14);
    EXPECT_EQ(t.normal(), Vec3(0, 0, 1));
  }
  const Triangle needle{{1, 1, 1}, {1e7 + 1, 1, 1}, {1, 2, 1}};
  EXPECT_DOUBLE_EQ(needle.area(), 0.5e7);
  const Triangle none{{1, 2, 3}, {2, 4, 6}, {3, 6, 9}};
  EXPECT_EQ(none.area(), 0);
  EXPECT_EQ(none.normal(), Vec3());
}

TEST(Triangle, RayHitsWhereItWasAimed) {
  RandomU random(12);
  for (int i = 0; i < 2000; ++i) {
    const double x = 1.5 * random.next() - 0.25;
    const double y = 1.5 * random.next() - 0.25;
    const Vec3 target{2 * x, 4 * y, x};
    const Vec3 origin{10.0 * random.next() - 5, 10.0 * random.next() - 5, 7};
    const auto hit = kSkewed.intersect(origin, (target - origin) * 0.25, 0, kFar);
    ASSERT_EQ(hit.has_value(), x > 0 && y > 0 && x + y < 1) << x << " " << y;
    if (!hit) continue;
    EXPECT_NEAR(hit->t, 4, 1e-13);
    EXPECT_LT(length(hit->point.position - target), 1e-14);
  }
}

TEST(Triangle, EdgesAndVerticesBelongToIt) {
  const Triangle t{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Triangle turned{t.a, t.c, t.b};
  for (const Vec3& p :
       {Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0, 0}, {0, 0.25, 0}, {0.5, 0.5, 0}})
    for (const auto& triangle : {t, turned})
      EXPECT_TRUE(triangle.intersect(p + Vec3{0, 0, 1}, {0, 0, -1}, 0, INFINITY))
          << p.x << " " << p.y;
}

TEST(Triangle, RaysThroughACommonEdgeHitAtLeastOneOfTwo) {
  // Vertices and rays without an exact binary fraction.
  const Vec3 a{0.1, 0.7, 0.3}, b{-0.9, 0.13, 0.77}, c{1.3, 0.2, -0.4}, d{-0.3, -1.1, 0.2};
  const Triangle left{a, b, d}, right{a, d, c};
  RandomU random(13);
  for (int i = 0; i < 20000; ++i) {
    const float s = random.next();
    const Vec3 target = a * (1 - s) + d * s;
    const Vec3 origin{random.next(), random.next(), 9};
    const auto direction = target - origin;
    ASSERT_TRUE(left.intersect(origin, direction, 0, INFINITY) ||
                right.intersect(origin, direction, 0, INFINITY));
  }
}

TEST(Triangle, RaysOutOfRangeInThePlaneOrNaNDoNotHit) {
  const Triangle t{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_TRUE(t.intersect({0.25, 0.25, 2}, {0, 0, -1}, 1, 3));
  EXPECT_FALSE(t.intersect({0.25, 0.25, 2}, {0, 0, -1}, 2, 3));
  EXPECT_FALSE(t.intersect({0.25, 0.25, 2}, {0, 0, -1}, 1, 2));
  EXPECT_FALSE(t.intersect({0.25, 0.25, 2}, {0, 0, 1}, 0, kFar));
  EXPECT_FALSE(t.intersect({-1, 0.25, 0}, {1, 0, 0}, 0, kFar));
  EXPECT_FALSE(t.intersect({0.25, 0.25, 2}, {0, 0, 0}, 0, kFar));
  EXPECT_FALSE(t.intersect({NAN, 0.25, 2}, {0, 0, -1}, 0, kFar));
  EXPECT_FALSE(t.intersect({0.25, 0.25, 2}, {0, 0, NAN}, 0, kFar));
}

}  // namespace
}  // namespace lucerna::testing

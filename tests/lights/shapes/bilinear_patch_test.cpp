#include "lights/shapes/bilinear_patch.h"

#include <gtest/gtest.h>

#include "tests/lights/area_helpers.h"
#include "tests/lights/shapes/shape_helpers.h"

namespace lucerna::testing {
namespace {

/// z = x y over the unit square: a saddle, whose normal is (-y, -x, 1).
const BilinearPatch kSaddle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
/// A trapezoid in the plane x = 2, from base y = 0..4 to top y = 1..2 at height 3.
const BilinearPatch kTrapezoid{{2, 0, 0}, {2, 4, 0}, {2, 1, 3}, {2, 2, 3}};

TEST(BilinearPatch, AreaOfFlatPatchesIsExact) {
  const BilinearPatch rectangle{{1, 1, 1}, {4, 1, 1}, {1, 3, 1}, {4, 3, 1}};
  EXPECT_EQ(rectangle.area(), 6);
  EXPECT_DOUBLE_EQ(kTrapezoid.area(), 7.5);
  // Two corners coincide: a triangle with legs 2 and 1.
  const BilinearPatch triangle{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 1, 0}};
  EXPECT_DOUBLE_EQ(triangle.area(), 1);
  const BilinearPatch line{{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {2, 0, 0}};
  EXPECT_EQ(line.area(), 0);
}

TEST(BilinearPatch, AreaOfABowTieCountsBothLoops) {
  // Its sides cross in the middle: two triangles of base 1 and height 1/2, one of each orientation.
  const BilinearPatch bow{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const BilinearPatchArea area = bow.measure();
  EXPECT_NEAR(area.m2, 0.5, 1e-12);
  EXPECT_LE(std::fabs(area.m2 - 0.5), area.error_m2 + 1e-15);
  // The weights at the corners are equal here, so points crowd towards the middle.  dp/du x dp/dv
  // is 1 - 2 v, which is 1/2 a quarter of the way up.
  EXPECT_NEAR(bow.pdf_area({0.5, 0.25, 0}).per_m2, 2, 1e-12);
}

/// The area of a patch, computed differently from the code, in long double.  Along u it is a closed
/// form, along v two Gauss points in each of many strips.
double area_by_strips(const BilinearPatch& p) {
  using Wide = BasicVec3<long double>;
  const Wide p00(p.p00), p10(p.p10), p01(p.p01), p11(p.p11);
  const Wide twist = p11 - p10 - p01 + p00;
  const Wide change = cross(p10 - p00, twist);  // of dp/du x dp/dv along u
  const long double a = dot(change, change);
  // The integral of sqrt(a t^2 + d2) from 0 to t.
  const auto root = [a](long double t, long double d2) {
    const long double s = std::sqrt(a * t * t + d2);
    const long double more = d2 > 0 ? d2 / std::sqrt(a) * std::asinh(std::sqrt(a / d2) * t) : 0;
    return (t * s + more) / 2;
  };
  constexpr int kStrips = 20000;
  const long double node = 0.5L / std::sqrt(3.0L);
  long double sum = 0;
  for (int i = 0; i < 2 * kStrips; ++i) {
    const long double v = (i / 2 + 0.5L + (i % 2 == 0 ? -node : node)) / kStrips;
    const Wide n = cross(p10 - p00 + twist * v, p01 - p00);
    const Wide off = cross(n, change);
    const long double nearest = -dot(n, change) / a, d2 = dot(off, off) / a;
    sum += root(1 - nearest, d2) - root(-nearest, d2);
  }
  return static_cast<double>(sum / (2 * kStrips));
}

TEST(BilinearPatch, AreaByQuadratureIsWithinItsError) {
  RandomU random(46);
  const auto coordinate = [&] { return 4.0 * random.next() - 2; };
  int precise = 0;
  for (int i = 0; i < 100; ++i) {
    BilinearPatch p;
    for (auto* corner : {&p.p00, &p.p10, &p.p01, &p.p11})
      *corner = {coordinate(), coordinate(), coordinate()};
    const BilinearPatchArea area = p.measure();
    EXPECT_GT(area.error_m2, 0);
    EXPECT_NEAR(area.m2, area_by_strips(p), area.error_m2 + 1e-12 * area.m2) << i;
    precise += area.error_m2 <= 1e-8 * area.m2 ? 1 : 0;
  }
  EXPECT_GE(precise, 90);
  const BilinearPatchArea saddle = kSaddle.measure();
  EXPECT_GT(saddle.error_m2, 0);
  EXPECT_NEAR(saddle.m2, area_by_strips(kSaddle), saddle.error_m2);
  EXPECT_LE(saddle.error_m2, 1e-8 * saddle.m2);
  // Folded along a line: less precise, with a larger stated error.
  const BilinearPatchArea dart =
      BilinearPatch{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 0}}.measure();
  EXPECT_NEAR(dart.m2, 0.25 + 2. / 27, dart.error_m2);
  EXPECT_LE(dart.error_m2, 1e-4 * dart.m2);
  EXPECT_EQ(kTrapezoid.measure().error_m2, 0);
}

TEST(BilinearPatch, FlatAndBentDoNotDependOnSize) {
  for (const double size : {1e-90, 1e-45, 1.0, 1e40, 1e85}) {
    const auto scaled = [size](BilinearPatch p) {
      for (auto* corner : {&p.p00, &p.p10, &p.p01, &p.p11}) *corner = *corner * size;
      return p;
    };
    const double saddle = scaled(kSaddle).area() / (size * size);
    EXPECT_NEAR(saddle, kSaddle.area(), 1e-12) << size;
    EXPECT_GT(scaled(kSaddle).measure().error_m2, 0) << size;
    EXPECT_NEAR(scaled(kTrapezoid).area() / (size * size), 7.5, 1e-12) << size;
    EXPECT_EQ(scaled(kTrapezoid).measure().error_m2, 0) << size;
    EXPECT_TRUE(scaled(kSaddle).is_unfolded()) << size;
  }
}

TEST(BilinearPatch, NormalIsTheCrossProductOfTheDerivatives) {
  const Vec3 expected = normalized(Vec3(-0.75, -0.25, 1));
  EXPECT_LT(length(kSaddle.normal({0.25, 0.75}) - expected), 1e-15);
  EXPECT_LT(length(kTrapezoid.normal({0.5, 0.5}) - Vec3(1, 0, 0)), 1e-15);
  EXPECT_EQ(kSaddle.at({0.25, 0.75}), Vec3(0.25, 0.75, 0.1875));
}

TEST(BilinearPatch, DensityFindsItsPointForPatchesOfManyForms) {
  // Weights at the corners over the share of area.  Both are known from (u, v) itself.
  RandomU random(43);
  const auto coordinate = [&] { return 4.0 * random.next() - 2; };
  for (int patch = 0; patch < 200; ++patch) {
    BilinearPatch p;
    for (auto* corner : {&p.p00, &p.p10, &p.p01, &p.p11})
      *corner = {coordinate(), coordinate(), coordinate()};
    const auto derivative_cross = [&](double u, double v) {
      const auto du = (p.p10 - p.p00) * (1 - v) + (p.p11 - p.p01) * v;
      const auto dv = (p.p01 - p.p00) * (1 - u) + (p.p11 - p.p10) * u;
      return length(cross(du, dv));
    };
    const double w[4] = {derivative_cross(0, 0), derivative_cross(1, 0), derivative_cross(0, 1),
                         derivative_cross(1, 1)};
    for (int i = 0; i < 50; ++i) {
      const double u = random.next(), v = random.next();
      const double weight = (1 - v) * ((1 - u) * w[0] + u * w[1]) + v * ((1 - u) * w[2] + u * w[3]);
      const double expected = weight / ((w[0] + w[1] + w[2] + w[3]) / 4) / derivative_cross(u, v);
      EXPECT_NEAR(p.pdf_area(p.at({u, v})).per_m2 / expected, 1, 1e-6) << patch;
    }
  }
}

TEST(BilinearPatch, DensityWhereAPatchFoldsOverItselfCountsBothLayers) {
  // On the diagonal, x = u - 3/4 u^2, which u = 1/2 and u = 5/6 share.  There |dp/du x dp/dv| = |1
  // - 3/2 u| is 1/4 both times.  At the corners it is 1, 1/4, 1/4, 1/2, of mean 1/2.  The weights
  // between them are 1/2 and 4/9.
  const BilinearPatch dart{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 0}};
  const double expected = (0.5 + 4. / 9) / 0.25 / 0.5;
  EXPECT_NEAR(dart.pdf_area(dart.at({0.5, 0.5})).per_m2 / expected, 1, 1e-9);
  EXPECT_NEAR(dart.pdf_area(dart.at({5. / 6, 5. / 6})).per_m2 / expected, 1, 1e-9);
}

TEST(BilinearPatch, RaysHitTheSaddleWhereItIs) {
  RandomU random(44);
  for (int i = 0; i < 2000; ++i) {
    const double x = 1.5 * random.next() - 0.25, y = 1.5 * random.next() - 0.25;
    Vec2 uv;
    const auto hit = kSaddle.intersect({x, y, 9}, {0, 0, -3}, 0, kFar, &uv);
    ASSERT_EQ(hit.has_value(), x >= 0 && y >= 0 && x <= 1 && y <= 1);
    if (!hit) continue;
    EXPECT_NEAR(hit->t, (9 - x * y) / 3, 1e-14);
    EXPECT_NEAR(hit->point.position.z, x * y, 1e-15);
    EXPECT_NEAR(uv.x, x, 1e-14);
    EXPECT_NEAR(uv.y, y, 1e-14);
    EXPECT_LT(length(hit->point.normal - normalized(Vec3(-y, -x, 1))), 1e-14);
  }
}

TEST(BilinearPatch, RaysMayHitTwiceAndTheNearestComesFirst) {
  // Along x = y at z = 1/4 + t/8: t^2 = z has two solutions, from either end.
  const Vec3 origin{-1, -1, 0.0625}, direction{1, 1, 0.125};
  // Points s (1, 1, 1/8) + origin: (s - 1)^2 = 1/16 + s/8: s = 17/16 -+ sqrt((17/16)^2 - 15/16).
  const double root = std::sqrt(17. * 17 / 256 - 15. / 16);
  const auto found = kSaddle.hits(origin, direction, 0, kFar);
  ASSERT_EQ(found.count, 1);  // the other is at x = s - 1 < 0
  EXPECT_NEAR(found.hit[0].t, 17. / 16 + root, 1e-14);
  const BilinearPatch wide{{-1, -1, 1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, 1}};  // z = x y
  for (const double sign : {1., -1.}) {
    const auto both = wide.hits({-2 * sign, -2 * sign, 0.25}, {sign, sign, 0}, 0, kFar);
    ASSERT_EQ(both.count, 2);  // x = y = -+ 1/2
    EXPECT_NEAR(both.hit[0].t, 1.5, 1e-14);
    EXPECT_NEAR(both.hit[1].t, 2.5, 1e-14);
  }
}

TEST(BilinearPatch, EdgesBelongToItAndFarRaysStillHit) {
  const BilinearPatch square{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  for (const float x : {0.0, 0.5, 1.0})
    for (const float y : {0.0, 0.25, 1.0})
      for (const float z : {1.0, 1e6})
        EXPECT_TRUE(square.intersect({x, y, z}, {0, 0, -1}, 0, INFINITY)) << x << y << z;
  EXPECT_FALSE(square.intersect({1.0001, 0.5, 1}, {0, 0, -1}, 0, INFINITY));
  EXPECT_FALSE(square.intersect({-1, 0.5, 0}, {1, 0, 0}, 0, INFINITY));
  EXPECT_FALSE(square.intersect({0.5, 0.5, NAN}, {0, 0, -1}, 0, INFINITY));
  EXPECT_FALSE(square.intersect({0.5, 0.5, 1}, {0, 0, 0}, 0, INFINITY));
}

}  // namespace
}  // namespace lucerna::testing

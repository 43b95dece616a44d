// Solved paths against closed forms: images, Snell's law at a slab, and the mirror equation of a
// ball.
#include "server/visibility/specular_path.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace lucerna {
namespace {

SmoothPart plane(const Vec3& n, const Vec3& at, double eta = 1) {
  SmoothPart p;
  p.n = normalized(n);
  p.middle = at;
  p.half_u = Frame::around(p.n).s * 10.0;
  p.half_v = Frame::around(p.n).t * 10.0;
  p.eta = eta;
  return p;
}

TEST(SpecularPath, ByMirrorsLeadsToTheImage) {
  const SmoothPart a = plane({1, 0.05, 0}, {-1, 0, 0}), b = plane({0, 1, 0.05}, {0, -1, 0});
  const std::array<SmoothStep, 2> steps{SmoothStep{&a, false}, SmoothStep{&b, false}};
  const Vec3 from{0.5, 0.2, 0.2}, to{0.8, 0, -0.6};
  const auto path = path_to_point(from, steps, to);
  ASSERT_TRUE(path);
  const Vec3 image = mirror_image(a, mirror_image(b, to));
  const double distance = length(image - from);
  EXPECT_LT(length(path->start - (image - from) / distance), 1e-12);
  EXPECT_NEAR(path->spread * distance * distance, 1, 1e-9);
  EXPECT_NEAR(a.height(path->points[0]), 0, 1e-12);
  EXPECT_NEAR(b.height(path->points[1]), 0, 1e-12);
}

// The angle by bisection.  Rays between two angles lie in a ring, whose area gives the spread.
TEST(SpecularPath, ThroughASlabFollowsSnellsLaw) {
  for (const double eta : {1.5, 1 / 1.5}) {
    const SmoothPart bottom = plane({0, 0, -1}, {0, 0, 0.5}, eta),
                     top = plane({0, 0, 1}, {0, 0, 1}, eta);
    const std::array<SmoothStep, 2> steps{SmoothStep{&bottom, true}, SmoothStep{&top, true}};
    for (const double away : {1e-6, 0.1, 0.8, 1.5}) {
      const auto lateral = [&](double sine) {
        return 1.5 * sine / std::sqrt(1 - sine * sine) +
               0.5 * sine / std::sqrt(eta * eta - sine * sine);
      };
      double low = 0, high = std::fmin(1, eta);
      for (int i = 0; i < 200; ++i)
        (lateral((low + high) / 2) < away ? low : high) = (low + high) / 2;
      const double sine = low, cosine = std::sqrt(1 - sine * sine);
      const auto path = path_to_point({0, 0, 0}, steps, {away * 0.6, away * 0.8, 2});
      ASSERT_TRUE(path) << eta << ", " << away;
      EXPECT_NEAR(path->start.z, cosine, 1e-10) << eta << ", " << away;
      EXPECT_LT(length(path->end - path->start), 1e-10);
      // d(lateral)/d(sine) = 1.5 / cos^3 + 0.5 eta^2 / (eta^2 - sine^2)^1.5
      const double inside = eta * eta - sine * sine;
      const double slope =
          1.5 / (cosine * cosine * cosine) + 0.5 * eta * eta / (inside * std::sqrt(inside));
      // d(solid angle) / d(area of the ring across the ray) = sin d(angle) / (away d(away) cos)
      const double spread = sine / (cosine * cosine * slope * away);
      EXPECT_NEAR(path->spread / spread, 1, 1e-6) << eta << ", " << away;
    }
  }
}

TEST(SpecularPath, ToADirectionThroughASlabKeepsIt) {
  const SmoothPart bottom = plane({0, 0, -1}, {0, 0, 0.5}, 1.5),
                   top = plane({0, 0, 1}, {0, 0, 1}, 1.5);
  const std::array<SmoothStep, 2> steps{SmoothStep{&bottom, true}, SmoothStep{&top, true}};
  const Vec3 w = normalized(Vec3{0.6, 0.2, 0.5});
  const auto path = path_to_direction({0, 0, 0}, steps, w);
  ASSERT_TRUE(path);
  EXPECT_LT(length(path->start - w), 1e-10);
  EXPECT_NEAR(path->spread, 1, 1e-9);
}

TEST(SpecularPath, EndsAtTotalReflection) {
  const SmoothPart top = plane({0, 0, 1}, {0, 0, 1}, 1.5);
  const std::array<SmoothStep, 1> steps{SmoothStep{&top, true}};
  // From inside of the glass, no direction beyond the surface is lower than this one.
  EXPECT_FALSE(path_to_direction({0, 0, 0}, steps, normalized(Vec3{1, 0, -0.1})));
}

SmoothPart ball(const Vec3& centre, double radius) {
  SmoothPart p;
  p.is_sphere = true;
  p.middle = centre;
  p.radius_m = radius;
  return p;
}

TEST(SpecularPath, AtABallHasEqualAngles) {
  const SmoothPart mirror = ball({0.1, -0.2, 0.9}, 0.4);
  const std::array<SmoothStep, 1> steps{SmoothStep{&mirror, false}};
  const Vec3 from{1.4, 0.3, 0}, to{1.3, -0.8, 1.7};
  const auto path = path_to_point(from, steps, to);
  ASSERT_TRUE(path);
  const Vec3 n = (path->points[0] - mirror.middle) / mirror.radius_m;
  EXPECT_NEAR(length(n), 1, 1e-12);
  EXPECT_LT(length(path->end - (path->start - n * (2 * dot(n, path->start)))), 1e-12);
  EXPECT_LT(length(normalized(to - path->points[0]) - path->end), 1e-10);
}

// The mirror equation: light that leaves a point at the distance p spreads as if it came from
// 1 / (1/p + 2/r) behind the surface.
TEST(SpecularPath, AtABallSpreadsByTheMirrorEquation) {
  const double r = 0.7, p = 1.3, q = 2.1;
  const SmoothPart mirror = ball({0, 0, 0}, r);
  const std::array<SmoothStep, 1> steps{SmoothStep{&mirror, false}};
  const auto path = path_to_point({0, 0, r + p}, steps, {1e-9, 0, r + q});
  ASSERT_TRUE(path);
  const double across = p + q + 2 * p * q / r;
  EXPECT_NEAR(path->spread * across * across, 1, 1e-6);
}

}  // namespace
}  // namespace lucerna

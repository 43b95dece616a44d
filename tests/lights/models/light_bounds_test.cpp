#include "lights/models/light_bounds.h"

#include <gtest/gtest.h>

#include "lights/maths/vec.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna::testing {
namespace {

TEST(LightBounds, APointReachesExactlyItsCone) {
  const LightBounds bounds{{1, 2, 3}, {1, 2, 3}, {0, 0, 1}, kPi / 6};
  const auto at = [&](double angle, double distance) {
    return bounds.reaches({1 + distance * std::sin(angle), 2, 3 + distance * std::cos(angle)});
  };
  for (const double distance : {1e-3, 1., 1e6}) {
    EXPECT_TRUE(at(0, distance));
    EXPECT_TRUE(at(kPi / 6 - 1e-9, distance));
    EXPECT_FALSE(at(kPi / 6 + 1e-9, distance));
    EXPECT_FALSE(at(kPi, distance));
  }
  EXPECT_TRUE(bounds.reaches({1, 2, 3}));
}

TEST(LightBounds, AHalfSpaceOfAFlatBoxEndsAtItsPlane) {
  // A one-sided rectangle: nothing behind it, not even beside its centre, within its bounding
  // sphere.
  const LightBounds bounds{{-1, -1, 0}, {1, 1, 0}, {0, 0, 1}, kPi / 2};
  for (const double x : {0., 0.5, 3., 1000.}) {
    EXPECT_TRUE(bounds.reaches({x, 0, 1e-3}));
    EXPECT_FALSE(bounds.reaches({x, 0, -1e-3}));
  }
}

TEST(LightBounds, ConesAboveAHalfSpaceLeaveOutPlacesFarBehind) {
  const LightBounds bounds{{-1, -1, -1}, {1, 1, 1}, {0, 0, 1}, 3 * kPi / 4};
  EXPECT_TRUE(bounds.reaches({100, 0, -50}));
  EXPECT_FALSE(bounds.reaches({0, 0, -100}));
  EXPECT_TRUE(bounds.reaches({0, 0, -1}));
}

TEST(LightBounds, AWholeSphereOfDirectionsReachesEverywhere) {
  const LightBounds bounds{{0, 0, 0}, {1, 0, 2}, {0, 0, 1}, kPi};
  RandomU random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto at = random.pair();
    EXPECT_TRUE(bounds.reaches(Region{}.at(at.x, at.y) * std::exp(40.0 * random.next() - 20)));
  }
  EXPECT_TRUE(bounds.reaches({0, 0, -1e300}));
}

// Each receiver is a point of the box plus a direction of the cone, so light may reach it.
void expect_reaches_what_a_ray_meets(double offset) {
  RandomU random(2);
  for (int i = 0; i < 100000; ++i) {
    const auto number = [&] { return 2.0 * random.next() - 1; };
    const Vec3 a{offset + number(), number(), number()};
    const double flat = i % 3 == 0 ? 0 : 1;  // one third of the boxes have no thickness
    const Vec3 size{flat * random.next(), 1.0 * random.next(), 1.0 * random.next()};
    const auto turn = random.pair();
    LightBounds bounds;
    bounds.lower = a;
    bounds.upper = a + size;
    bounds.axis = Region{}.at(turn.x, turn.y);
    bounds.cone_rad = kPi * random.next() * random.next();
    const auto share = [&](double low, double high) {
      const double t = i % 2 == 0 ? random.next() : random.next() < 0.5 ? 0 : 1;
      return double{low} + (double{high} - double{low}) * t;
    };
    const Vec3 from{share(bounds.lower.x, bounds.upper.x), share(bounds.lower.y, bounds.upper.y),
                    share(bounds.lower.z, bounds.upper.z)};
    const double angle = bounds.cone_rad * (i % 5 == 0 ? 1.0 : double{random.next()});
    const double phi = 2 * kPi * random.next();
    const Vec3 w = Frame::around(normalized(Vec3(bounds.axis)))
                       .world_from_local({std::sin(angle) * std::cos(phi),
                                          std::sin(angle) * std::sin(phi), std::cos(angle)});
    const Vec3 to(from + w * std::exp(20.0 * random.next() - 10));
    // A receiver that is rounded to double may lie beyond the cone's edge by that rounding.  It
    // counts where the angle from the start of its ray is still in the cone.
    const Vec3 way = Vec3(to) - from;
    const Vec3 n(bounds.axis);
    if (std::atan2(length(cross(n, way)), dot(n, way)) > bounds.cone_rad) continue;
    ASSERT_TRUE(bounds.reaches(to)) << i;
  }
}

TEST(LightBounds, ReachesEveryRayFromTheBoxWithinTheCone) {
  expect_reaches_what_a_ray_meets(0);
  expect_reaches_what_a_ray_meets(1e6);
  expect_reaches_what_a_ray_meets(0);
  expect_reaches_what_a_ray_meets(1e9);
}

TEST(LightBounds, ReceiversThatAreNotFiniteAreNotLeftOut) {
  const LightBounds bounds{{0, 0, 0}, {1, 1, 1}, {0, 0, 1}, 1};
  EXPECT_TRUE(bounds.reaches({NAN, 0, 0}));
}

}  // namespace
}  // namespace lucerna::testing

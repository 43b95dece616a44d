#include "lights/shapes/sphere.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/lights/area_helpers.h"
#include "tests/lights/shapes/shape_helpers.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;
TEST(Sphere, AreaOfWholeAndCutSpheres) {
  EXPECT_DOUBLE_EQ(Sphere::create({.radius_m = 3})->area(), 36 * kPi);
  // A zone of height 1.5 on a sphere of radius 2 swept by 1 rad, doubled in size by the map.
  const auto cut = *Sphere::create({.radius_m = 2,
                                    .z_min_m = -0.5,
                                    .z_max_m = 1,
                                    .phi_max_rad = 1,
                                    .world_from_object = *Transform::scale({2, -2, 2})});
  EXPECT_DOUBLE_EQ(cut.area(), 1 * 2 * 1.5 * 4);
  EXPECT_TRUE(cut.emissive_error().ok());
}

TEST(Sphere, UnequalScaleCannotEmitAndGivesTheReason) {
  const auto sphere = *Sphere::create({.world_from_object = *Transform::scale({1, 2, 1})});
  EXPECT_EQ(sphere.emissive_error().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(sphere.emissive_error().message()), HasSubstr("(1, 2, 1)"));
}

TEST(Sphere, DensityOfEachSampleIsFoundAgainAwayFromTheOrigin) {
  // A sphere whose rounding in float is a tenth of its radius.
  const auto sphere =
      *Sphere::create({.radius_m = 1e-6, .world_from_object = Transform::translate({1, 2, 3})});
  RandomU random(32);
  for (int i = 0; i < 2000; ++i) {
    const auto s = sphere.sample({-4, 7, 1}, random.pair());
    ASSERT_GT(s.pdf.per_sr, 0);
    ASSERT_EQ(s.pdf, sphere.pdf({-4, 7, 1}, s.point));
    // The other side is never mistaken for this one.
    if (dot(s.point.normal, normalized(Vec3(-5, 5, -2))) < 0.01) continue;
    const SurfacePoint behind{s.point.position, -s.point.normal};
    ASSERT_EQ(sphere.pdf({-4, 7, 1}, behind).per_sr, 0);
  }
}

TEST(Sphere, SamplesAtTheRimOfTheConeHaveTheDensityOfAllOthers) {
  const auto sphere =
      *Sphere::create({.radius_m = 0.3, .world_from_object = *Transform::rotate(1, {1, 2, 3})});
  const Vec3 receiver{1.1, -0.7, 2.3};
  for (int i = 0; i < 1000; ++i) {
    const auto s = sphere.sample(receiver, {1, static_cast<float>(i) / 1000});
    EXPECT_EQ(s.pdf, sphere.pdf(receiver, s.point));
  }
}

TEST(Sphere, RaysMeetItAtTheExpectedPlaces) {
  const auto sphere =
      *Sphere::create({.radius_m = 5, .world_from_object = Transform::translate({0, 0, 10})});
  // x = 3: z = 10 -+ 4.
  const auto hit = sphere.intersect({3, 0, 0}, {0, 0, 2}, 0, INFINITY);
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->t, 3);
  EXPECT_EQ(hit->point.position, Vec3(3, 0, 6));
  EXPECT_NEAR(hit->point.normal.x, 0.6, 1e-15);
  EXPECT_NEAR(hit->point.normal.z, -0.8, 1e-15);
  const auto second = sphere.intersect({3, 0, 0}, {0, 0, 2}, 3.5, INFINITY);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->t, 7);
  EXPECT_FALSE(sphere.intersect({3, 0, 0}, {0, 0, 2}, 3.5, 6.5));
  EXPECT_FALSE(sphere.intersect({5.001, 0, 0}, {0, 0, 1}, 0, INFINITY));
  EXPECT_FALSE(sphere.intersect({0, 0, 0}, {0, 0, 0}, 0, INFINITY));
  EXPECT_FALSE(sphere.intersect({0, NAN, 0}, {0, 0, 1}, 0, INFINITY));
  EXPECT_FALSE(sphere.intersect({0, 0, 0}, {0, 0, NAN}, 0, INFINITY));
}

TEST(Sphere, SmallSpheresAreHitFromAfarWithoutCancellation) {
  const auto sphere = *Sphere::create({.radius_m = 1e-3});
  for (const double d : {1e3, 1e6, 1e9}) {
    for (const double offset : {0., 0.3, 0.6, 0.9}) {
      const double x = offset * 1e-3;
      const auto hit = sphere.intersect({x, 0, d}, {0, 0, -1}, 0, kFar);
      ASSERT_TRUE(hit) << d;
      EXPECT_NEAR(hit->point.position.x / 1e-3, offset, 1e-14);
      EXPECT_NEAR(hit->point.position.z / 1e-3, std::sqrt(1 - offset * offset), 1e-14);
    }
    EXPECT_FALSE(sphere.intersect({1.001e-3, 0, d}, {0, 0, -1}, 0, kFar));
  }
}

TEST(Sphere, CutsLetRaysThroughToTheSecondHit) {
  // The bowl below z = 0: from above, the ray passes the missing cap and meets the inside.
  const auto bowl = *Sphere::create({.radius_m = 2, .z_max_m = 0});
  const auto inside = bowl.intersect({0, 1, 5}, {0, 0, -1}, 0, kFar);
  ASSERT_TRUE(inside);
  EXPECT_NEAR(inside->point.position.z, -std::sqrt(3), 1e-15);
  EXPECT_LT(inside->point.normal.z, 0);  // the normal of the outside
  EXPECT_EQ(bowl.hits({0, 1, 5}, {0, 0, -1}, 0, kFar).count, 1);
  EXPECT_FALSE(bowl.intersect({0, 5, 1}, {0, -1, 0}, 0, kFar));
  // Swept from +x over +y: half of the sphere, with y > 0.
  const auto half = *Sphere::create({.radius_m = 2, .phi_max_rad = kPi});
  const auto back = half.intersect({1, -5, 0}, {0, 1, 0}, 0, kFar);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->point.position.y, std::sqrt(3), 1e-15);
  EXPECT_FALSE(half.intersect({-5, -1, 0}, {1, 0, 0}, 0, kFar));
}

TEST(Sphere, EllipsoidsMirrorsAndReversalKeepTheNormalOnTheOutside) {
  const auto first_normal = [](const Transform& map, bool reverse) {
    const auto s = *Sphere::create({.reverse_orientation = reverse, .world_from_object = map});
    return s.intersect({0, 0.5, 9}, {0, 0, -1}, 0, kFar)->point;
  };
  // y^2 + z^2 / 4 = 1 at y = 1/2: z = sqrt 3, gradient (0, 1, sqrt(3) / 2).
  const Vec3 gradient = normalized(Vec3(0, 1, std::sqrt(3) / 2));
  const auto ellipsoid = first_normal(*Transform::scale({1, 1, 2}), false);
  EXPECT_NEAR(ellipsoid.position.z, std::sqrt(3), 1e-15);
  EXPECT_LT(length(ellipsoid.normal - gradient), 1e-15);
  EXPECT_LT(length(first_normal(*Transform::scale({1, 1, -2}), false).normal - gradient), 1e-15);
  EXPECT_LT(length(first_normal(*Transform::scale({1, 1, 2}), true).normal + gradient), 1e-15);
}

TEST(Sphere, BoundsHoldAllHitsAndAreTight) {
  const Transform map = Transform::translate({1, 2, 3}) * *Transform::rotate(1, {1, 2, -1}) *
                        *Transform::scale({0.5, 2, -1});
  const auto whole = *Sphere::create({.world_from_object = map});
  const auto cut = *Sphere::create({.z_min_m = 0.5, .world_from_object = map});
  const auto [lower, upper] = whole.bounds();
  const auto [cut_lower, cut_upper] = cut.bounds();
  Vec3 most = Vec3(lower), least = Vec3(upper);
  for (int i = 0; i < 200; ++i)
    for (int j = 0; j < 400; ++j) {
      const double theta = kPi * (i + 0.5) / 200, phi = 2 * kPi * j / 400;
      const Vec3 object{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                        std::cos(theta)};
      const auto p = map.point(object);
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_TRUE(p[axis] >= lower[axis] && p[axis] <= upper[axis]);
        ASSERT_TRUE(object.z < 0.5 || (p[axis] >= cut_lower[axis] && p[axis] <= cut_upper[axis]));
      }
      most = {std::fmax(most.x, p.x), std::fmax(most.y, p.y), std::fmax(most.z, p.z)};
      least = {std::fmin(least.x, p.x), std::fmin(least.y, p.y), std::fmin(least.z, p.z)};
    }
  EXPECT_LT(length(most - Vec3(upper)), 1e-3);
  EXPECT_LT(length(least - Vec3(lower)), 1e-3);
}

TEST(Sphere, RefusesParametersOutsideTheirDomain) {
  const auto message = [](const SphereParams& p) {
    return std::string(Sphere::create(p).status().message());
  };
  EXPECT_THAT(message({.radius_m = -1}), HasSubstr("sphere.radius_m = -1, allowed"));
  EXPECT_THAT(message({.radius_m = NAN}), HasSubstr("sphere.radius_m = nan, allowed"));
  EXPECT_THAT(message({.z_min_m = 1}), HasSubstr("sphere.z_min_m = 1, allowed less than"));
  EXPECT_THAT(message({.z_max_m = -1}), HasSubstr("sphere.z_max_m = -1, allowed more than"));
  EXPECT_THAT(message({.z_min_m = 0.5, .z_max_m = 0.25}), HasSubstr("z_min_m, 0.5"));
  EXPECT_THAT(message({.z_max_m = NAN}), HasSubstr("sphere.z_max_m = nan"));
  EXPECT_THAT(message({.phi_max_rad = 0}), HasSubstr("sphere.phi_max_rad = 0, allowed (0, 2 pi]"));
}

}  // namespace
}  // namespace lucerna::testing

#include "lights/shapes/disk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lights/sampling/spherical_ellipse.h"
#include "tests/lights/area_helpers.h"
#include "tests/lights/shapes/shape_helpers.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;
TEST(Disk, AreaOfAnnulusAndSectorUnderAnAffineMap) {
  const auto disk = *Disk::create({.radius_m = 2,
                                   .inner_radius_m = 1,
                                   .phi_max_rad = kPi / 2,
                                   .world_from_object = *Transform::scale({3, 0.5, 7})});
  // A quarter of pi (4 - 1), stretched by 3 x 1/2.
  EXPECT_DOUBLE_EQ(disk.area(), 3 * kPi / 4 * 1.5);
  EXPECT_DOUBLE_EQ(Disk::create({.radius_m = 3})->area(), 9 * kPi);
  EXPECT_TRUE(disk.emissive_error().ok());
}

/// The shares of a point of object space in the area of the annulus 0.5 < r < 2, phi < 4.
Vec2 disk_share(const Vec3& p) {
  const double phi = std::atan2(p.y, p.x);
  return {(p.x * p.x + p.y * p.y - 0.25) / 3.75, (phi < 0 ? phi + 2 * kPi : phi) / 4};
}

TEST(Disk, SamplesAreUniformByAreaOnASectorOfAnEllipse) {
  // A shear and unequal scales make an ellipse in a tilted plane.
  const Transform map = matrix({{{2, 0.5, 0.25, 1}, {0, 1, 0.5, 2}, {0.25, 0, 1, 3}}});
  const auto disk = *Disk::create({.height_m = 1,
                                   .radius_m = 2,
                                   .inner_radius_m = 0.5,
                                   .phi_max_rad = 4,
                                   .world_from_object = map});
  RandomU random(21);
  const double p = uniformity_p_value([&] {
    const auto s = disk.sample({9, 9, 9}, random.pair());
    const Vec3 object = map.inverse().point(s.point.position);
    EXPECT_NEAR(object.z, 1, 1e-14);
    return disk_share(object);
  });
  EXPECT_GT(p, kUnlikely);
}

TEST(Disk, UniformityTestRejectsARadiusThatIsUniform) {
  RandomU random(21);
  const double p = uniformity_p_value([&] {
    const auto u = random.pair();
    const double r = 0.5 + 1.5 * u.x;
    return disk_share({r * std::cos(4 * u.y), r * std::sin(4 * u.y), 1});
  });
  EXPECT_LT(p, kUnlikely);
}

/// A receiver that requests sampling by solid angle.
Receiver by_solid_angle(const Vec3& position) {
  Receiver receiver(position);
  receiver.area_sampling = AreaSampling::kSolidAngle;
  return receiver;
}

TEST(Disk, DensityBySolidAngleFollowsTheDiskThroughMapsOfEqualScale) {
  // The ellipse of a disk of radius 2 at the origin, seen from (3, 0, 4), at any place.
  const auto ellipse = *SphericalEllipse::create(3, 4, 2);
  const Transform map = Transform::translate({1, 2, 3}) * *Transform::rotate(1, {1, 2, -1}) *
                        *Transform::scale({0.5, -0.5, 0.5});
  const auto disk = *Disk::create({.height_m = 1, .radius_m = 2, .world_from_object = map});
  const auto receiver = by_solid_angle(map.point({3, 0, 5}));
  RandomU random(24);
  for (int i = 0; i < 200; ++i) {
    const auto s = disk.sample(receiver, random.pair());
    EXPECT_EQ(s.pdf, disk.pdf(receiver, s.point));
    const Vec3 p = map.inverse().point(s.point.position);
    EXPECT_NEAR(p.z, 1, 1e-14);
    EXPECT_NEAR(s.pdf.per_sr / ellipse.pdf({-p.x, -p.y}), 1, 1e-9);
  }
}

TEST(Disk, OnlyWholeCirclesAreSampledBySolidAngleFromOutsideTheirPlane) {
  const auto is_by_area = [](const DiskParams& params, const Vec3& r) {
    const auto disk = *Disk::create(params);
    const auto s = disk.sample(by_solid_angle(r), {0.3, 0.6});
    EXPECT_EQ(s.pdf, disk.pdf(by_solid_angle(r), s.point));
    return s.point.position == disk.sample(by_area(r), {0.3, 0.6}).point.position;
  };
  EXPECT_FALSE(is_by_area({.radius_m = 2}, {3, 0, 4}));
  EXPECT_FALSE(is_by_area({.radius_m = 2}, {3, 0, -4}));
  EXPECT_TRUE(is_by_area({.radius_m = 2, .inner_radius_m = 1}, {3, 0, 4}));
  EXPECT_TRUE(is_by_area({.radius_m = 2, .phi_max_rad = 6}, {3, 0, 4}));
  EXPECT_TRUE(is_by_area({.world_from_object = *Transform::scale({1, 2, 1})}, {3, 0, 4}));
  EXPECT_TRUE(is_by_area({.radius_m = 2}, {3, 0, 0}));
  EXPECT_TRUE(is_by_area({.radius_m = 2}, {1, 0, 0}));
  EXPECT_TRUE(is_by_area({.radius_m = 2}, {1e7, 0, 1e7}));
}

TEST(Disk, NormalFollowsTheMapAndStaysOnItsSideUnderMirrors) {
  const auto normal = [](const Transform& map, bool reverse) {
    return Disk::create({.reverse_orientation = reverse, .world_from_object = map})
        ->sample({5, 5, 5}, {0.5, 0.5})
        .point.normal;
  };
  EXPECT_EQ(normal({}, false), Vec3(0, 0, 1));
  EXPECT_EQ(normal({}, true), Vec3(0, 0, -1));
  EXPECT_EQ(normal(*Transform::scale({-1, 1, 1}), false), Vec3(0, 0, 1));
  EXPECT_EQ(normal(*Transform::scale({1, 1, -1}), false), Vec3(0, 0, -1));
  // z' = z + x: the plane z' = x', whose upward normal is (-1, 0, 1) / sqrt 2.
  const auto sheared = normal(matrix({{{1, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 1, 0}}}), false);
  EXPECT_NEAR(length(sheared - Vec3(-std::sqrt(0.5), 0, std::sqrt(0.5))), 0, 1e-15);
}

TEST(Disk, RaysHitTheRemainingPart) {
  const auto disk =
      *Disk::create({.height_m = 1, .radius_m = 2, .inner_radius_m = 1, .phi_max_rad = kPi});
  const auto hit = [&](float x, float y) {
    return disk.intersect({x, y, 5}, {0, 0, -2}, 0, INFINITY);
  };
  ASSERT_TRUE(hit(1.5, 0.5));
  EXPECT_EQ(hit(1.5, 0.5)->t, 2);
  EXPECT_EQ(hit(1.5, 0.5)->point.position, Vec3(1.5, 0.5, 1));
  EXPECT_TRUE(hit(2, 0));
  EXPECT_TRUE(hit(0, 1));
  EXPECT_FALSE(hit(0, 0.75));
  EXPECT_FALSE(hit(1.75, 1.75));
  EXPECT_FALSE(hit(0.5, -1.5));
  EXPECT_FALSE(disk.intersect({0, 1.5, 5}, {0, 0, -2}, 0, 2));
  EXPECT_FALSE(disk.intersect({0, 1.5, 5}, {0, 0, -2}, 2, 9));
  EXPECT_FALSE(disk.intersect({-5, 1.5, 1}, {1, 0, 0}, 0, INFINITY));
  EXPECT_FALSE(disk.intersect({0, 1.5, NAN}, {0, 0, -1}, 0, INFINITY));
}

TEST(Disk, HitsAboutADistantOriginStayInThePlane) {
  const Vec3 origin{1e7, -3e6, 2e6};
  const auto disk =
      *Disk::create({.radius_m = 2, .world_from_object = Transform::translate(origin)}, origin);
  const auto hit = disk.intersect({0.5, 0.25, 3}, {0, 0, -1}, 0, INFINITY);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->point.position, Vec3(0.5, 0.25, 0));
  const auto [lower, upper] = disk.bounds();
  EXPECT_NEAR(lower.x, -2, 1e-6);
  EXPECT_NEAR(upper.y, 2, 1e-6);
}

TEST(Disk, RefusesParametersOutsideTheirDomain) {
  const auto message = [](const DiskParams& p) {
    return std::string(Disk::create(p).status().message());
  };
  EXPECT_THAT(message({.height_m = NAN}), HasSubstr("disk.height_m = nan, allowed finite"));
  EXPECT_THAT(message({.radius_m = 0}), HasSubstr("disk.radius_m = 0, allowed finite and > 0"));
  EXPECT_THAT(message({.inner_radius_m = 1}),
              HasSubstr("disk.inner_radius_m = 1, allowed [0, radius 1)"));
  EXPECT_THAT(message({.phi_max_rad = 7}), HasSubstr("disk.phi_max_rad = 7, allowed (0, 2 pi]"));
  EXPECT_THAT(message({.world_from_object = Transform::translate({1.7e308, 0, 0}) *
                                            *Transform::scale({1e308, 1e308, 1e308})}),
              HasSubstr("finite bounds"));
}

}  // namespace
}  // namespace lucerna::testing

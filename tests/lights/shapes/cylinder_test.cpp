#include "lights/shapes/cylinder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/lights/area_helpers.h"
#include "tests/lights/shapes/shape_helpers.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;
TEST(Cylinder, AreaIsExactForEqualScaleAcrossAndAnyScaleAlong) {
  EXPECT_DOUBLE_EQ(Cylinder::create({.radius_m = 3})->area(), 12 * kPi);
  // Swept by 1 rad, radius 2 doubled, height 1.5 stretched by five, rotated and mirrored.
  const auto part = *Cylinder::create(
      {.radius_m = 2,
       .z_min_m = -0.5,
       .z_max_m = 1,
       .phi_max_rad = 1,
       .world_from_object = *Transform::rotate(1, {1, 2, 3}) * *Transform::scale({2, -2, 5})});
  EXPECT_TRUE(part.emissive_error().ok());
  EXPECT_NEAR(part.area(), 4 * 7.5, 1e-13);
}

TEST(Cylinder, MapsThatMakeAreaUnevenCannotEmitAndGiveTheReason) {
  const auto refusal = [](const Transform& map) {
    const auto cylinder = *Cylinder::create({.world_from_object = map});
    EXPECT_EQ(cylinder.area(), 0);
    EXPECT_EQ(cylinder.emissive_error().code(), absl::StatusCode::kInvalidArgument);
    return std::string(cylinder.emissive_error().message());
  };
  EXPECT_THAT(refusal(*Transform::scale({1, 2, 3})), HasSubstr("by (1, 2, 3)"));
  // The axis is tilted.  The ends stay circles of equal size, but points crowd on one side.
  EXPECT_THAT(refusal(matrix({{{1, 0, 0.5, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}})),
              HasSubstr("no shear"));
  EXPECT_THAT(refusal(matrix({{{1, 0.5, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}})),
              HasSubstr("no shear"));
}

/// The shares of a point of object space in the area of a tube |z| < 1 swept by 4 rad.
Vec2 cylinder_share(const Vec3& p) {
  const double phi = std::atan2(p.y, p.x);
  return {(p.z + 1) / 2, (phi < 0 ? phi + 2 * kPi : phi) / 4};
}

TEST(Cylinder, SamplesAreUniformByArea) {
  const Transform map = Transform::translate({1, 2, 3}) * *Transform::rotate(2, {3, 1, 1}) *
                        *Transform::scale({2, 2, 0.25});
  const auto tube =
      *Cylinder::create({.radius_m = 0.5, .phi_max_rad = 4, .world_from_object = map});
  RandomU random(31);
  const double p = uniformity_p_value([&] {
    const auto s = tube.sample({9, 9, 9}, random.pair());
    const Vec3 object = map.inverse().point(s.point.position);
    EXPECT_NEAR(std::hypot(object.x, object.y), 0.5, 1e-14);
    return cylinder_share(object);
  });
  EXPECT_GT(p, kUnlikely);
}

TEST(Cylinder, NormalsPointOutwardsThroughMirrorsTooUnlessReversed) {
  const auto normal = [](const Transform& map, bool reverse) {
    // u.y = 0: the point above +x.
    return Cylinder::create({.reverse_orientation = reverse, .world_from_object = map})
        ->sample({5, 5, 5}, {0.5, 0})
        .point.normal;
  };
  EXPECT_EQ(normal({}, false), Vec3(1, 0, 0));
  EXPECT_EQ(normal({}, true), Vec3(-1, 0, 0));
  EXPECT_EQ(normal(*Transform::scale({1, 1, -1}), false), Vec3(1, 0, 0));
  EXPECT_EQ(normal(*Transform::scale({-1, 1, 1}), false), Vec3(-1, 0, 0));
}

TEST(Cylinder, RaysHitBothSidesAndPassThroughCuts) {
  const auto tube =
      *Cylinder::create({.radius_m = 2, .z_min_m = 0, .z_max_m = 3, .phi_max_rad = 1.5 * kPi});
  // Along -x at y = 1, direction of length 2: at x = +-sqrt 3.
  const auto both = tube.hits({6, 1, 1}, {-2, 0, 0}, 0, kFar);
  ASSERT_EQ(both.count, 2);
  EXPECT_NEAR(both.hit[0].t, (6 - std::sqrt(3.)) / 2, 1e-15);
  EXPECT_NEAR(both.hit[1].t, (6 + std::sqrt(3.)) / 2, 1e-15);
  EXPECT_NEAR(length(both.hit[0].point.normal - Vec3(std::sqrt(0.75), 0.5, 0)), 0, 1e-15);
  // At y = -1 the near side, in the fourth quarter, is not swept.
  const auto far_side = tube.intersect({6, -1, 1}, {-1, 0, 0}, 0, kFar);
  ASSERT_TRUE(far_side);
  EXPECT_NEAR(far_side->point.position.x, -std::sqrt(3.), 1e-15);
  // A slanted ray through the open top: it meets only the far wall, where x = -2 and z = 2.
  const auto wall = tube.intersect({0, 0, 4}, {-1, 0, -1}, 0, kFar);
  ASSERT_TRUE(wall);
  EXPECT_NEAR(length(wall->point.position - Vec3(-2, 0, 2)), 0, 1e-15);
  // From within, and with limits of t.
  EXPECT_EQ(tube.hits({0, 0, 1}, {0, 1, 0}, 0, kFar).count, 1);
  EXPECT_FALSE(tube.intersect({0, 0, 1}, {0, 1, 0}, 0, 2));
  EXPECT_FALSE(tube.intersect({0, 0, 1}, {0, 1, 0}, 2, 9));
  // Above, beside, along the axis, and NaN.
  EXPECT_FALSE(tube.intersect({6, 1, 3.5}, {-1, 0, 0}, 0, kFar));
  EXPECT_FALSE(tube.intersect({6, 2.5, 1}, {-1, 0, 0}, 0, kFar));
  EXPECT_FALSE(tube.intersect({1, 0, -5}, {0, 0, 1}, 0, kFar));
  EXPECT_FALSE(tube.intersect({6, NAN, 1}, {-1, 0, 0}, 0, kFar));
  EXPECT_FALSE(tube.intersect({6, 1, 1}, {-1, 0, NAN}, 0, kFar));
}

TEST(Cylinder, HitsLieOnTheSurfaceUnderAnyAffineMap) {
  const Transform map = matrix({{{2, 0.5, 0.25, 1}, {0, 1, 0.5, 2}, {0.25, 0, 1, 3}}});
  const auto tube = *Cylinder::create({.radius_m = 0.75, .world_from_object = map});
  RandomU random(33);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto u = random.pair(), v = random.pair();
    const Vec3 o{20 * u.x - 9, 20 * u.y - 8, 15};
    const Vec3 d = map.point({2 * v.x - 1, 2 * v.y - 1, u.x - 0.5}) - o;
    for (int k = 0; k < tube.hits(o, d, 0, kFar).count; ++k, ++hits) {
      const auto hit = tube.hits(o, d, 0, kFar).hit[k];
      const Vec3 p = map.inverse().point(hit.point.position);
      EXPECT_NEAR(std::hypot(p.x, p.y), 0.75, 1e-14);
      EXPECT_LE(std::fabs(p.z), 1 + 1e-14);
      EXPECT_LT(length(o + d * hit.t - hit.point.position), 1e-12);
      // The normal is perpendicular to both tangents, as the map moves them.
      EXPECT_NEAR(dot(hit.point.normal, map.vector({-p.y, p.x, 0})), 0, 1e-14);
      EXPECT_NEAR(dot(hit.point.normal, map.vector({0, 0, 1})), 0, 1e-14);
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST(Cylinder, ThinTubesFarAwayAreHitWhereTheyAre) {
  // b^2 - 4 a c in double would be off by 1e-16 x 1e12 against r^2 = 1e-8.
  const auto tube = *Cylinder::create({.radius_m = 1e-4});
  for (const double y : {0., 0.5e-4, 0.99e-4}) {
    const auto both = tube.hits({1e6, y, 0}, {-1, 0, 0}, 0, kFar);
    ASSERT_EQ(both.count, 2) << y;
    EXPECT_NEAR(both.hit[0].point.position.x, std::sqrt(1e-8 - y * y), 1e-15);
    EXPECT_NEAR(both.hit[1].point.position.x, -std::sqrt(1e-8 - y * y), 1e-15);
  }
  EXPECT_EQ(tube.hits({1e6, 1.01e-4, 0}, {-1, 0, 0}, 0, kFar).count, 0);
}

TEST(Cylinder, BoundsHoldItTightly) {
  const Transform map = matrix({{{2, 0.5, 0.25, 1}, {0, 1, 0.5, 2}, {0.25, 0, 1, 3}}});
  const auto tube = *Cylinder::create({.radius_m = 2, .world_from_object = map});
  const auto [lower, upper] = tube.bounds();
  Vec3 low{kFar, kFar, kFar}, high = -low;
  for (int i = 0; i < 4096; ++i)
    for (const double z : {-1., 1.}) {
      const double phi = 2 * kPi * i / 4096;
      const Vec3 p = map.point({2 * std::cos(phi), 2 * std::sin(phi), z});
      low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y), std::fmin(low.z, p.z)};
      high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y), std::fmax(high.z, p.z)};
    }
  EXPECT_LT(length(Vec3(lower) - low), 1e-5);
  EXPECT_LT(length(Vec3(upper) - high), 1e-5);
  EXPECT_TRUE(lower.x <= low.x && lower.y <= low.y && lower.z <= low.z);
  EXPECT_TRUE(upper.x >= high.x && upper.y >= high.y && upper.z >= high.z);
}

TEST(Cylinder, RefusesParametersOutsideTheirDomain) {
  const auto message = [](const CylinderParams& p) {
    return std::string(Cylinder::create(p).status().message());
  };
  EXPECT_THAT(message({.radius_m = 0}), HasSubstr("cylinder.radius_m = 0, allowed finite and > 0"));
  EXPECT_THAT(message({.z_min_m = -INFINITY}), HasSubstr("cylinder.z_min_m = -inf"));
  EXPECT_THAT(message({.z_min_m = 1}),
              HasSubstr("cylinder.z_max_m = 1, allowed finite, more than"));
  EXPECT_THAT(message({.phi_max_rad = 0}),
              HasSubstr("cylinder.phi_max_rad = 0, allowed (0, 2 pi]"));
  EXPECT_THAT(message({.world_from_object = Transform::translate({1.7e308, 0, 0}) *
                                            *Transform::scale({1e308, 1e308, 1e308})}),
              HasSubstr("finite bounds"));
}

}  // namespace
}  // namespace lucerna::testing

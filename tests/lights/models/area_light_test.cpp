#include "lights/models/area_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/area_helpers.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

constexpr Rgb kLevel{1, 2, 4};

/// The square |x|, |y| < 1 in the plane z = 0, emitting upwards.
AreaLight square(bool two_sided = false, double size = 1) {
  const Vec3 a{-size, -size, 0}, b{size, -size, 0}, c{size, size, 0}, d{-size, size, 0};
  return *AreaLight::create({kLevel, two_sided}, *TriangleMesh::create({{a, b, c}, {a, c, d}}));
}

/// A box about the origin, from -1 to 1, as patches that face outwards.
std::vector<BilinearPatch> box() {
  std::vector<BilinearPatch> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0, 1.0}) {
      const auto corner = [&](float s, float t) {
        const float v[3] = {side, side * s, t};  // the handedness of the face changes with its side
        return Vec3{v[(3 - axis) % 3], v[(4 - axis) % 3], v[(5 - axis) % 3]};
      };
      faces.push_back({corner(-1, -1), corner(1, -1), corner(-1, 1), corner(1, 1)});
    }
  return faces;
}

TEST(AreaLight, PolygonFollowsLambertsFormula) {
  const Vec3 receiver{0.5, 2, 1.5};
  const Vec3 n = normalized(Vec3(-0.1, -0.5, -1));
  const double closed_form =
      lambert_polygon({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, Vec3(receiver), n);
  expect_estimates(illuminance(square(), receiver, n, 61), closed_form, 0.01);
}

TEST(AreaLight, LambertsFormulaOfTheTestsAgreesWithADistantSquare) {
  // Area times cosines over squared distance, to second order in size / distance.
  const double e =
      lambert_polygon({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {300, 0, 400}, {0, 0, -1});
  EXPECT_NEAR(e / (4 * 0.8 * 0.8 / 250000), 1, 1e-5);
}

TEST(AreaLight, OnlyFacesTurnedToTheReceiverCountForAClosedMesh) {
  const auto light = *AreaLight::create({Rgb(1), false}, *PatchMesh::create(box()));
  EXPECT_DOUBLE_EQ(light.shape().area(), 24);
  const Vec3 receiver{3, 2, 0.5};
  const Vec3 r(receiver), n = normalized(-r);
  const double closed_form =
      lambert_polygon({{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}}, r, n) +
      lambert_polygon({{-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}, {1, 1, -1}}, r, n);
  expect_estimates(illuminance(light, receiver, n, 62), closed_form, 0.02);
  // The companion: for a two-sided light, the far faces would count too.
  const auto both = *AreaLight::create({Rgb(1), true}, *PatchMesh::create(box()));
  EXPECT_GT(illuminance(both, receiver, n, 62).mean, 1.2 * closed_form);
  // From within, all faces are dark: no sample carries light.
  EXPECT_EQ(illuminance(light, Vec3{0.5, 0.25, 0}, {0, 0, 1}, 63).mean, 0);
}

TEST(AreaLight, DensityOfADirectionCountsOnlyFacesTurnedToTheReceiver) {
  const auto mesh = *PatchMesh::create(box());
  const auto one = *AreaLight::create({kLevel, false}, mesh);
  const auto two = *AreaLight::create({kLevel, true}, mesh);
  // From (3, 0, 0) towards the centre: faces at distances 2 and 4, both seen face on, of area 24.
  const Vec3 r{3, 0.25, 0}, wi{-1, 0, 0};
  EXPECT_DOUBLE_EQ(one.pdf_li(by_area(r), wi).per_sr, 4 / 24.0);
  EXPECT_DOUBLE_EQ(two.pdf_li(by_area(r), wi).per_sr, (4 + 16) / 24.0);
  EXPECT_EQ(one.pdf_li(by_area(r), -wi).per_sr, 0);
}

TEST(AreaLight, OneSidedLightIsDarkBehindAndInItsPlane) {
  const auto one = square();
  const auto two = square(true);
  const auto reason = [](const auto& light, const Vec3& r) {
    const auto s = light.sample_li(r, {0.5, 0.25});
    EXPECT_EQ(s.value.is_black(), s.reason != NoLight::kNone);
    EXPECT_TRUE(s.pdf.per_sr > 0 && std::isfinite(s.pdf.per_sr));
    return s.reason;
  };
  EXPECT_EQ(reason(one, {3, 0, 1}), NoLight::kNone);
  EXPECT_EQ(reason(one, {3, 0, -1}), NoLight::kBehind);
  EXPECT_EQ(reason(two, {3, 0, -1}), NoLight::kNone);
  EXPECT_EQ(reason(one, {3, 0, 0}), NoLight::kBehind);
  EXPECT_EQ(reason(two, {3, 0, 0}), NoLight::kBehind);
  EXPECT_EQ(one.pdf_li({3, 0, 0}, Vec3{-1, 0, 0}).per_sr, 0);
}

TEST(AreaLight, GrazingReceiversGetExactValuesDownToTinyCosines) {
  const auto light = square();
  for (const float height : {1e-3, 1e-10, 1e-20}) {
    const Vec3 receiver{4, 0, height};
    const auto s = light.sample_li(by_area(receiver), {0.5, 0.25});
    ASSERT_EQ(s.reason, NoLight::kNone) << height;
    // d^2 / (A cos) with cos = height / d.
    const Vec3 d = Vec3(receiver) - Vec3(s.point);
    const double expected = std::pow(dot(d, d), 1.5) / 4 / height;
    EXPECT_NEAR(s.pdf.per_sr / expected, 1, 1e-6) << height;
  }
  // A density that exceeds doubles gives 0 with a reason.
  const Vec3 too_low{4, 0, 1e-310};
  EXPECT_EQ(light.sample_li(by_area(too_low), {0.5, 0.25}).reason, NoLight::kOutOfRange);
}

TEST(AreaLight, ReceiverOnTheLightIsDegenerate) {
  const auto light = square();
  const auto point = light.sample_li(by_area(Vec3{0, 0, 1}), {0.25, 0.5}).point;
  EXPECT_EQ(light.sample_li(point, {0.25, 0.5}).reason, NoLight::kDegenerate);
  for (const Vec3& r : {Vec3{1, 1, 0}, {0, -1, 0}, {0.3, 0.2, 0}, {0, 0, 0}}) {
    const auto s = light.sample_li(r, {0.125, 0.75});
    EXPECT_EQ(s.reason, NoLight::kDegenerate);
    EXPECT_TRUE(is_finite(s.wi) && is_finite(s.value));
    EXPECT_EQ(light.pdf_li(r, Vec3{0, 0, -1}).per_sr, 0);
  }
  // Beside the sampled triangle in its plane, on the other triangle or not, and slightly beneath
  // the plane.
  for (const Vec3& r : {Vec3{0, 1, 0}, {3, 0.2, 0}, {-1.001, 0, 0}, {0.3, 0.2, -1e-20}})
    EXPECT_EQ(light.sample_li(r, {0.125, 0.75}).reason, NoLight::kBehind) << r.x;
}

TEST(AreaLight, ReceiversThatAreNotFiniteGiveNoLight) {
  const auto sphere = *AreaLight::create({kLevel}, *Sphere::create({}));
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    const auto s = sphere.sample_li({0, bad, 0}, {0.5, 0.5});
    EXPECT_EQ(s.reason, NoLight::kOutOfRange);
    EXPECT_TRUE(is_finite(s.wi) && is_finite(s.point) && is_finite(s.normal));
    EXPECT_EQ(s.pdf.per_sr, 1);
    EXPECT_EQ(sphere.pdf_li({0, bad, 0}, {{0, 0, 1}, {0, 0, 1}}).per_sr, 0);
    EXPECT_EQ(sphere.pdf_li({0, 0, 5}, Vec3{0, bad, -1}).per_sr, 0);
    EXPECT_TRUE(sphere.le({{0, 0, 1}, {0, 0, 1}}, {NAN, 0, 0}).is_black());
  }
}

TEST(AreaLight, SizesOf1eMinus18To1e18GiveTheSameDensities) {
  // Squares of these sizes exceed the range of float: 1e-46 and 1e38.
  const auto unit = square();
  for (const float size : {0x1p-60, 0x1p60}) {
    const auto light = square(false, size);
    const auto expected = unit.sample_li({3, 1, 2}, {0.3, 0.7});
    const auto s = light.sample_li({3 * size, size, 2 * size}, {0.3, 0.7});
    EXPECT_EQ(s.reason, NoLight::kNone);
    EXPECT_EQ(s.pdf, expected.pdf);
    EXPECT_EQ(s.wi, expected.wi);
    EXPECT_EQ(s.distance, expected.distance * size);
  }
}

TEST(AreaLight, BlackLightGivesItsReasonAndHasADensity) {
  const auto light = *AreaLight::create({}, *Disk::create({}));
  const auto s = light.sample_li({0, 0, 2}, {0.5, 0.5});
  EXPECT_EQ(s.reason, NoLight::kBlack);
  EXPECT_EQ(s.pdf, light.pdf_li({0, 0, 2}, {s.point, s.normal}));
  EXPECT_TRUE(light.power({}).lumens.is_black());
}

TEST(AreaLight, RadianceLeavesTheEmittingSideOnly) {
  const SurfacePoint p{{0, 0, 0}, {0, 0, 1}, 0};
  const Rgb level(kLevel);
  EXPECT_EQ(square().le(p, {0, 0.6, 0.8}), level);
  EXPECT_TRUE(square().le(p, {0, 0.6, -0.8}).is_black());
  EXPECT_TRUE(square().le(p, {1, 0, 0}).is_black());
  EXPECT_EQ(square(true).le(p, {0, 0.6, -0.8}), level);
}

TEST(AreaLight, PowerIsPiTimesRadianceTimesArea) {
  EXPECT_EQ(square().power({}).lumens, kLevel * (4 * kPi));
  EXPECT_EQ(square(true).power({}).lumens, kLevel * (8 * kPi));
  EXPECT_EQ(square().power({}).error_lumens, 0);
}

TEST(AreaLight, PowerOfABentPatchStatesItsQuadratureError) {
  // z = x y over the unit square, beside a flat patch.  Each square metre emits pi L on both sides.
  const BilinearPatch saddle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
  const BilinearPatch flat{{2, 0, 0}, {4, 0, 0}, {2, 1, 0}, {4, 1, 0}};
  const auto light = *AreaLight::create({kLevel, true}, *PatchMesh::create({saddle, flat}));
  // The integral of sqrt(1 + x^2 + y^2): along x in closed form, then by Simpson's rule.
  constexpr int kSteps = 2000;
  double area = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double c2 = 1 + double(i) * i / (double(kSteps) * kSteps);
    const double line = (std::sqrt(c2 + 1) + c2 * std::asinh(1 / std::sqrt(c2))) / 2;
    area += line * (i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2) / (3 * kSteps);
  }
  const Power power = light.power({});
  EXPECT_GT(power.error_lumens, 0);
  EXPECT_LE(power.error_lumens, 1e-8 * luminance(power.lumens));
  EXPECT_NEAR(luminance(power.lumens), luminance(kLevel) * 2 * kPi * (area + 2),
              power.error_lumens);
}

TEST(AreaLight, MirroredCutSphereEmitsOutwards) {
  // The cap z > 1 of a sphere of radius 2, mirrored to z < -1 and raised to 7.  From below, its
  // outside is visible.  The disk of its rim (radius sqrt 3, height 6) sends as much light.
  const Transform map = Transform::translate({0, 0, 7}) * *Transform::scale({1, 1, -1});
  const auto cap = *Sphere::create({.radius_m = 2, .z_min_m = 1, .world_from_object = map});
  const auto light = *AreaLight::create({Rgb(1)}, cap);
  expect_estimates(illuminance(light, Vec3{}, {0, 0, 1}, 64), kPi * 3 / (3 + 36), 0.01);
}

TEST(AreaLight, HalfSphereSeenFromTheSideGivesHalfTheLight) {
  // The upper half of a sphere gives half of pi L sin^2, by symmetry.  Its silhouette and far side
  // are sampled too.
  const auto half = *Sphere::create({.radius_m = 2, .z_min_m = 0});
  const auto light = *AreaLight::create({Rgb(1)}, half);
  expect_estimates(illuminance(light, Vec3{5, 0, 0}, {-1, 0, 0}, 65, 160000), kPi * 4 / 25 / 2,
                   0.01);
}

TEST(AreaLight, RefusesShapesThatCannotEmit) {
  const auto message = [](const Rgb& radiance, const Transform& map) {
    return std::string(AreaLight::create({radiance}, *Sphere::create({.world_from_object = map}))
                           .status()
                           .message());
  };
  EXPECT_THAT(message({1, -1, 1}, {}), HasSubstr("area.radiance = (1, -1, 1) cd/m2, allowed"));
  EXPECT_THAT(message({1, 1, NAN}, {}), HasSubstr("area.radiance"));
  EXPECT_THAT(message({INFINITY, 1, 1}, {}), HasSubstr("area.radiance"));
  EXPECT_THAT(message({1, 1, 1}, *Transform::scale({1, 1, 3})), HasSubstr("(1, 1, 3)"));
}

}  // namespace
}  // namespace lucerna::testing

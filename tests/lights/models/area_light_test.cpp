#include "lights/models/area_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lights/models/light.h"
#include "tests/lights/contract/area_helpers.h"

namespace lucerna::testing {
namespace {

using ::testing::HasSubstr;

constexpr Rgb<double> kLevel{1, 2, 4};

/// The square |x|, |y| < 1 in the plane z = 0, emitting upwards.
template <typename Real>
AreaLight<Real, TriangleMesh> square(bool two_sided = false, Real size = 1) {
  const Vec3<Real> a{-size, -size, 0}, b{size, -size, 0}, c{size, size, 0}, d{-size, size, 0};
  return *AreaLight<Real, TriangleMesh>::create(
      {kLevel, two_sided}, *TriangleMesh<Real>::create({{a, b, c}, {a, c, d}}));
}

/// A box about the origin, from -1 to 1, as patches that face outwards.
std::vector<BilinearPatch<float>> box() {
  std::vector<BilinearPatch<float>> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.F, 1.F}) {
      const auto corner = [&](float s, float t) {
        const float v[3] = {side, side * s, t};  // the handedness of the face changes with its side
        return Vec3<float>{v[(3 - axis) % 3], v[(4 - axis) % 3], v[(5 - axis) % 3]};
      };
      faces.push_back({corner(-1, -1), corner(1, -1), corner(-1, 1), corner(1, 1)});
    }
  return faces;
}

TEST(AreaLight, PolygonFollowsLambertsFormula) {
  const Vec3<float> receiver{0.5F, 2, 1.5F};
  const Vec3<double> n = normalized(Vec3<double>(-0.1, -0.5, -1));
  const double closed_form =
      lambert_polygon({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, Vec3<double>(receiver), n);
  expect_estimates(illuminance(square<float>(), receiver, n, 61), closed_form, 0.01);
}

TEST(AreaLight, LambertsFormulaOfTheTestsAgreesWithADistantSquare) {
  // Area times cosines over squared distance, to second order in size / distance.
  const double e =
      lambert_polygon({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {300, 0, 400}, {0, 0, -1});
  EXPECT_NEAR(e / (4 * 0.8 * 0.8 / 250000), 1, 1e-5);
}

TEST(AreaLight, OnlyFacesTurnedToTheReceiverCountForAClosedMesh) {
  const auto light = *AreaLight<float, PatchMesh>::create({Rgb<double>(1), false},
                                                          *PatchMesh<float>::create(box()));
  EXPECT_DOUBLE_EQ(light.area_m2(), 24);
  const Vec3<float> receiver{3, 2, 0.5F};
  const Vec3<double> r(receiver), n = normalized(-r);
  const double closed_form =
      lambert_polygon({{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}}, r, n) +
      lambert_polygon({{-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}, {1, 1, -1}}, r, n);
  expect_estimates(illuminance(light, receiver, n, 62), closed_form, 0.02);
  // The companion: for a two-sided light, the far faces would count too.
  const auto both = *AreaLight<float, PatchMesh>::create({Rgb<double>(1), true},
                                                         *PatchMesh<float>::create(box()));
  EXPECT_GT(illuminance(both, receiver, n, 62).mean, 1.2 * closed_form);
  // From within, all faces are dark: no sample carries light.
  EXPECT_EQ(illuminance(light, Vec3<float>{0.5F, 0.25F, 0}, {0, 0, 1}, 63).mean, 0);
}

TEST(AreaLight, DensityOfADirectionCountsOnlyFacesTurnedToTheReceiver) {
  const auto mesh = *PatchMesh<float>::create(box());
  const auto one = *AreaLight<float, PatchMesh>::create({kLevel, false}, mesh);
  const auto two = *AreaLight<float, PatchMesh>::create({kLevel, true}, mesh);
  // From (3, 0, 0) towards the centre: faces at distances 2 and 4, both seen face on, of area 24.
  const Vec3<float> r{3, 0.25F, 0}, wi{-1, 0, 0};
  EXPECT_FLOAT_EQ(one.pdf_li(by_area(r), wi).per_sr, 4 / 24.F);
  EXPECT_FLOAT_EQ(two.pdf_li(by_area(r), wi).per_sr, (4 + 16) / 24.F);
  EXPECT_EQ(one.pdf_li(by_area(r), -wi).per_sr, 0);
}

TEST(AreaLight, OneSidedLightIsDarkBehindAndInItsPlane) {
  const auto one = square<float>();
  const auto two = square<float>(true);
  const auto reason = [](const auto& light, const Vec3<float>& r) {
    const auto s = light.sample_li(r, {0.5F, 0.25F});
    EXPECT_EQ(s.value.is_black(), s.reason != NoLight::kNone);
    EXPECT_TRUE(s.pdf.per_sr > 0 && std::isfinite(s.pdf.per_sr));
    return s.reason;
  };
  EXPECT_EQ(reason(one, {3, 0, 1}), NoLight::kNone);
  EXPECT_EQ(reason(one, {3, 0, -1}), NoLight::kBehind);
  EXPECT_EQ(reason(two, {3, 0, -1}), NoLight::kNone);
  EXPECT_EQ(reason(one, {3, 0, 0}), NoLight::kBehind);
  EXPECT_EQ(reason(two, {3, 0, 0}), NoLight::kBehind);
  EXPECT_EQ(one.pdf_li({3, 0, 0}, Vec3<float>{-1, 0, 0}).per_sr, 0);
}

TEST(AreaLight, GrazingReceiversGetExactValuesDownToTinyCosines) {
  const auto light = square<float>();
  for (const float height : {1e-3F, 1e-10F, 1e-20F}) {
    const Vec3<float> receiver{4, 0, height};
    const auto s = light.sample_li(by_area(receiver), {0.5F, 0.25F});
    ASSERT_EQ(s.reason, NoLight::kNone) << height;
    // d^2 / (A cos) with cos = height / d.
    const Vec3<double> d = Vec3<double>(receiver) - Vec3<double>(s.point);
    const double expected = std::pow(dot(d, d), 1.5) / 4 / height;
    EXPECT_NEAR(s.pdf.per_sr / expected, 1, 1e-6) << height;
  }
  // A density that exceeds floats gives 0 with a reason.
  const Vec3<float> too_low{4, 0, 1e-44F};
  EXPECT_EQ(light.sample_li(by_area(too_low), {0.5F, 0.25F}).reason, NoLight::kOutOfRange);
}

TEST(AreaLight, ReceiverOnTheLightIsDegenerate) {
  const auto light = square<double>();
  const auto point = light.sample_li(by_area(Vec3<double>{0, 0, 1}), {0.25, 0.5}).point;
  EXPECT_EQ(light.sample_li(point, {0.25, 0.5}).reason, NoLight::kDegenerate);
  for (const Vec3<double>& r : {Vec3<double>{1, 1, 0}, {0, -1, 0}, {0.3, 0.2, 0}, {0, 0, 0}}) {
    const auto s = light.sample_li(r, {0.125, 0.75});
    EXPECT_EQ(s.reason, NoLight::kDegenerate);
    EXPECT_TRUE(is_finite(s.wi) && is_finite(s.value));
    EXPECT_EQ(light.pdf_li(r, Vec3<double>{0, 0, -1}).per_sr, 0);
  }
  // Beside the sampled triangle in its plane, on the other triangle or not, and slightly beneath
  // the plane.
  for (const Vec3<double>& r :
       {Vec3<double>{0, 1, 0}, {3, 0.2, 0}, {-1.001, 0, 0}, {0.3, 0.2, -1e-20}})
    EXPECT_EQ(light.sample_li(r, {0.125, 0.75}).reason, NoLight::kBehind) << r.x;
}

TEST(AreaLight, ReceiversThatAreNotFiniteGiveNoLight) {
  const auto sphere = *AreaLight<float, Sphere>::create({kLevel}, *Sphere<float>::create({}));
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    const auto s = sphere.sample_li({0, bad, 0}, {0.5F, 0.5F});
    EXPECT_EQ(s.reason, NoLight::kOutOfRange);
    EXPECT_TRUE(is_finite(s.wi) && is_finite(s.point) && is_finite(s.normal));
    EXPECT_EQ(s.pdf.per_sr, 1);
    EXPECT_EQ(sphere.pdf_li({0, bad, 0}, {{0, 0, 1}, {0, 0, 1}}).per_sr, 0);
    EXPECT_EQ(sphere.pdf_li({0, 0, 5}, Vec3<float>{0, bad, -1}).per_sr, 0);
    EXPECT_TRUE(sphere.le({{0, 0, 1}, {0, 0, 1}}, {NAN, 0, 0}).is_black());
  }
}

TEST(AreaLight, SizesOf1eMinus18To1e18GiveTheSameDensities) {
  // Squares of these sizes exceed the range of float: 1e-46 and 1e38.
  const auto unit = square<float>();
  for (const float size : {0x1p-60F, 0x1p60F}) {
    const auto light = square<float>(false, size);
    const auto expected = unit.sample_li({3, 1, 2}, {0.3F, 0.7F});
    const auto s = light.sample_li({3 * size, size, 2 * size}, {0.3F, 0.7F});
    EXPECT_EQ(s.reason, NoLight::kNone);
    EXPECT_EQ(s.pdf, expected.pdf);
    EXPECT_EQ(s.wi, expected.wi);
    EXPECT_EQ(s.distance, expected.distance * size);
  }
}

TEST(AreaLight, BlackLightGivesItsReasonAndHasADensity) {
  const auto light = *AreaLight<float, Disk>::create({}, *Disk<float>::create({}));
  const auto s = light.sample_li({0, 0, 2}, {0.5F, 0.5F});
  EXPECT_EQ(s.reason, NoLight::kBlack);
  EXPECT_EQ(s.pdf, light.pdf_li({0, 0, 2}, {s.point, s.normal}));
  EXPECT_TRUE(light.power({}).lumens.is_black());
}

TEST(AreaLight, RadianceLeavesTheEmittingSideOnly) {
  const SurfacePoint<float> p{{0, 0, 0}, {0, 0, 1}, 0};
  const Rgb<float> level(kLevel);
  EXPECT_EQ(square<float>().le(p, {0, 0.6F, 0.8F}), level);
  EXPECT_TRUE(square<float>().le(p, {0, 0.6F, -0.8F}).is_black());
  EXPECT_TRUE(square<float>().le(p, {1, 0, 0}).is_black());
  EXPECT_EQ(square<float>(true).le(p, {0, 0.6F, -0.8F}), level);
}

TEST(AreaLight, PowerIsPiTimesRadianceTimesArea) {
  EXPECT_EQ(square<float>().power({}).lumens, kLevel * (4 * kPi));
  EXPECT_EQ(square<float>(true).power({}).lumens, kLevel * (8 * kPi));
  EXPECT_EQ(square<float>().power({}).error_lumens, 0);
}

TEST(AreaLight, PowerOfABentPatchStatesItsQuadratureError) {
  // z = x y over the unit square, beside a flat patch.  Each square metre emits pi L on both sides.
  const BilinearPatch<double> saddle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
  const BilinearPatch<double> flat{{2, 0, 0}, {4, 0, 0}, {2, 1, 0}, {4, 1, 0}};
  const auto light = *AreaLight<double, PatchMesh>::create(
      {kLevel, true}, *PatchMesh<double>::create({saddle, flat}));
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
  const auto cap = *Sphere<float>::create({.radius_m = 2, .z_min_m = 1, .world_from_object = map});
  const auto light = *AreaLight<float, Sphere>::create({Rgb<double>(1)}, cap);
  expect_estimates(illuminance(light, Vec3<float>{}, {0, 0, 1}, 64), kPi * 3 / (3 + 36), 0.01);
}

TEST(AreaLight, HalfSphereSeenFromTheSideGivesHalfTheLight) {
  // The upper half of a sphere gives half of pi L sin^2, by symmetry.  Its silhouette and far side
  // are sampled too.
  const auto half = *Sphere<float>::create({.radius_m = 2, .z_min_m = 0});
  const auto light = *AreaLight<float, Sphere>::create({Rgb<double>(1)}, half);
  expect_estimates(illuminance(light, Vec3<float>{5, 0, 0}, {-1, 0, 0}, 65, 160000),
                   kPi * 4 / 25 / 2, 0.01);
}

TEST(AreaLight, RefusesShapesThatCannotEmit) {
  const auto message = [](const Rgb<double>& radiance, const Transform& map) {
    return std::string(AreaLight<float, Sphere>::create(
                           {radiance}, *Sphere<float>::create({.world_from_object = map}))
                           .status()
                           .message());
  };
  EXPECT_THAT(message({1, -1, 1}, {}), HasSubstr("area.radiance = (1, -1, 1) cd/m2, allowed"));
  EXPECT_THAT(message({1, 1, NAN}, {}), HasSubstr("area.radiance"));
  EXPECT_THAT(message({1e39, 1, 1}, {}), HasSubstr("area.radiance"));
  EXPECT_THAT(message({1, 1, 1}, *Transform::scale({1, 1, 3})), HasSubstr("(1, 1, 3)"));
}

}  // namespace
}  // namespace lucerna::testing

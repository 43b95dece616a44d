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
AreaLight square(bool two_sided = false) {
  const Vec3 a{-1, -1, 0}, b{1, -1, 0}, c{1, 1, 0}, d{-1, 1, 0};
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
  // A density that exceeds doubles.
  EXPECT_EQ(one.sample_li(by_area({4, 0, 1e-310}), {0.5, 0.25}).reason, NoLight::kOutOfRange);
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

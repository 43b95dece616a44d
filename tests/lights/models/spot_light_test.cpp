#include "lights/models/spot_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/maths/vec.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

double degrees(double d) { return d * kPi / 180; }

SpotLightParams spot(double cone_rad, double start_rad) {
  return {.axis = {0, 0, -1},
          .intensity_cd = Rgb(1),
          .cone_half_angle_rad = cone_rad,
          .falloff_start_rad = start_rad};
}

SpotLight make(double cone_rad, double start_rad) {
  return *SpotLight::create(spot(cone_rad, start_rad));
}

/// Away from the light, `angle_rad` off its axis.
Vec3 off_axis(double angle_rad) { return {std::sin(angle_rad), 0, -std::cos(angle_rad)}; }

// By hand for 30 and 25 degrees: t = (cos 27.5 - cos 30) / (cos 25 - cos 30) = 0.520958, and t^2 (3
// - 2 t) = 0.531419; the other angles likewise.
TEST(SpotLight, EdgeIsSmoothstepInTheCosine) {
  const auto light = make(degrees(30), degrees(25));
  EXPECT_EQ(light.intensity(off_axis(0)).r, 1);
  EXPECT_EQ(light.intensity(off_axis(degrees(24.99))).r, 1);
  EXPECT_NEAR(light.intensity(off_axis(degrees(26))).r, 0.9086027064234259, 1e-12);
  EXPECT_NEAR(light.intensity(off_axis(degrees(27.5))).r, 0.5314185732783507, 1e-12);
  EXPECT_NEAR(light.intensity(off_axis(degrees(29))).r, 0.1171334640677985, 1e-12);
  EXPECT_EQ(light.intensity(off_axis(degrees(30.01))).r, 0);
  EXPECT_EQ(light.intensity(off_axis(kPi)).r, 0);
}

TEST(SpotLight, SampleIsIntensityOverDistanceSquared) {
  auto params = spot(degrees(30), degrees(25));
  params.position_m = {1, 2, 7};
  params.axis = {0, 0, -1e-5};
  params.intensity_cd = {100, 50, 25};
  const auto s = SpotLight::create(params)->sample_li({1, 2, 2}, {});
  EXPECT_EQ(s.reason, NoLight::kNone);
  EXPECT_TRUE(s.delta);
  EXPECT_EQ(s.value, Rgb(4, 2, 1));
  EXPECT_EQ(s.wi, Vec3(0, 0, 1));
  EXPECT_EQ(s.distance, 5);
}

TEST(SpotLight, ReceiversOutsideTheConeGiveAReason) {
  const auto light = make(degrees(30), degrees(25));
  const auto s = light.sample_li({1, 0, -1}, {});
  EXPECT_EQ(s.reason, NoLight::kOutsideCone);
  EXPECT_TRUE(s.value.is_black());
  EXPECT_EQ(light.sample_li({0, 0, 0}, {}).reason, NoLight::kDegenerate);
  auto params = spot(1, 0);
  params.intensity_cd = {};
  EXPECT_EQ(SpotLight::create(params)->sample_li({0, 0, -1}, {}).reason, NoLight::kBlack);
}

TEST(SpotLight, HardEdgeIsFullInsideAndDarkOutside) {
  for (const double cone : {1e-6, 0.01, 0.5, 1.5, 2.5}) {
    const auto light = make(cone, cone);
    EXPECT_EQ(light.intensity(off_axis(0)).r, 1);
    EXPECT_EQ(light.intensity(off_axis(cone * (1 - 1e-6))).r, 1) << cone;
    EXPECT_EQ(light.intensity(off_axis(cone * (1 + 1e-6))).r, 0) << cone;
  }
}

TEST(SpotLight, EdgesAsNarrowAs1eMinus6KeepTheirMiddleAndTheAxis) {
  for (const double width : {1e-2, 1e-4, 1e-6}) {
    const auto light = make(0.5, 0.5 - width);
    EXPECT_EQ(light.intensity(off_axis(0)).r, 1);
    EXPECT_EQ(light.intensity(off_axis(0.5 - 1.01 * width)).r, 1);
    EXPECT_EQ(light.intensity(off_axis(0.5 + 0.01 * width)).r, 0);
    // The smoothstep's middle.  The curvature of the cosine adds about width / 2 of its slope.
    EXPECT_NEAR(light.intensity(off_axis(0.5 - 0.5 * width)).r, 0.5, 1.5 * width);
    EXPECT_NEAR(light.intensity(off_axis(0.5 - 0.75 * width)).r, 0.84375, 1.5 * width);
  }
}

// pi theta^2 (1 - theta^2 / 12) is 2 pi (1 - cos theta) to theta^4 / 360, 3e-10 at 1 degree.
TEST(SpotLight, NarrowConesKeepTheirPower) {
  for (const double deg : {1., 0.05, 0.01, 1e-5, 1e-8}) {
    const double theta = degrees(deg);
    const double expected = kPi * theta * theta * (1 - theta * theta / 12);
    const auto light = make(theta, theta);
    EXPECT_NEAR(light.power({}).lumens.r / expected, 1, 3e-10) << deg;
  }
}

TEST(SpotLight, NarrowConesIlluminateOnlyPlacesWithinThem) {
  for (const double deg : {1., 0.05, 0.01, 1e-5}) {
    const double theta = degrees(deg);
    const auto light = make(theta, theta / 2);
    // Aside along x by tan(angle) at distance 1: the float is exact to 6e-8 of itself.
    const auto at = [&](double share) {
      return light.sample_li({static_cast<float>(std::tan(share * theta)), 0, -1}, {});
    };
    EXPECT_NEAR(at(0).value.r, 1, 1e-6);
    EXPECT_EQ(at(0.499).reason, NoLight::kNone);
    EXPECT_NEAR(at(0.499).value.r, std::pow(std::cos(0.499 * theta), 2), 1e-6) << deg;
    // For narrow cones 1 - cos is theta^2 / 2: t = (1 - 0.75^2) / (1 - 0.5^2) = 7/12.
    EXPECT_NEAR(at(0.75).value.r, 49. / 144 * (3 - 7. / 6), 2e-4) << deg;
    EXPECT_EQ(at(1.001).reason, NoLight::kOutsideCone) << deg;
    EXPECT_EQ(at(2).reason, NoLight::kOutsideCone) << deg;
  }
}

/// In float, a direction's own error is as wide as the narrowest cones.  A change of its length
/// must not change the intensity.
TEST(SpotLight, IntensityOfAFloatDirectionIgnoresItsErrorOfLength) {
  const auto light = make(degrees(1e-5), degrees(1e-5));
  EXPECT_EQ(light.intensity({0, 0, -1}).r, 1);
  EXPECT_EQ(light.intensity({0, 0, -1 + 0x1p-22}).r, 1);
  EXPECT_EQ(light.intensity({1e-7, 0, -1}).r, 1);
  EXPECT_EQ(light.intensity({2e-7, 0, -1}).r, 0);
  EXPECT_EQ(light.intensity({0, 0, 0}).r, 0);
  EXPECT_EQ(light.intensity({NAN, 0, 0}).r, 0);
}

TEST(SpotLight, ConesOf90DegreesAndMoreDoNotFoldOver) {
  const auto half = make(kPi / 2, kPi / 2);
  EXPECT_EQ(half.intensity(off_axis(degrees(89.99))).r, 1);
  EXPECT_EQ(half.intensity(off_axis(degrees(90.01))).r, 0);
  EXPECT_NEAR(half.power({}).lumens.r, 2 * kPi, 1e-14);
  const auto wide = make(degrees(120), degrees(100));
  EXPECT_EQ(wide.intensity(off_axis(degrees(99))).r, 1);
  EXPECT_GT(wide.intensity(off_axis(degrees(119))).r, 0);
  EXPECT_EQ(wide.intensity(off_axis(degrees(121))).r, 0);
}

TEST(SpotLight, FullSphereIsAPointLight) {
  const auto light = make(kPi, kPi);
  testing::RandomU random(3);
  for (int i = 0; i < 10000; ++i) {
    const auto w = testing::Region{}.at(random.next(), random.next());
    EXPECT_EQ(light.intensity(Vec3(w)).r, 1);
  }
  for (const Vec3& axis : {Vec3{1, 1, 1}, {1, 2, 3}, {-0.1, 0.7, 0.3}}) {
    auto params = spot(kPi, kPi);
    params.axis = axis;
    const auto turned = *SpotLight::create(params);
    EXPECT_EQ(turned.intensity(Vec3(normalized(-axis))).r, 1);
    EXPECT_EQ(turned.sample_li(Vec3(-axis), {}).reason, NoLight::kNone);
  }
  EXPECT_DOUBLE_EQ(light.power({}).lumens.r, 4 * kPi);
}

// The angle does not come from an arc cosine, which is NaN for a product of 1 + ulp.
TEST(SpotLight, AxisIsLitFullyForEveryAxis) {
  testing::RandomU random(4);
  for (int i = 0; i < 10000; ++i) {
    auto params = spot(0.01, 0.001);
    params.axis = testing::Region{}.at(random.next(), random.next());
    const auto light = *SpotLight::create(params);
    ASSERT_EQ(light.intensity(Vec3(params.axis)).r, 1);
    ASSERT_EQ(light.sample_li(Vec3(params.axis), {}).reason, NoLight::kNone);
  }
}

TEST(SpotLight, DistancesWhoseSquaresADoubleCannotHoldAreExact) {
  for (const double d : {1e-160, 1e-20, 1e19, 1e160}) {
    auto params = spot(0.5, 0.2);
    params.intensity_cd = Rgb(d < 1 ? 1e-15 : 1e30);
    const auto s = SpotLight::create(params)->sample_li({0, 0, -d}, {});
    EXPECT_EQ(s.reason, NoLight::kNone) << d;
    EXPECT_NEAR(s.value.g * d / params.intensity_cd.g * d, 1, 1e-12) << d;
  }
  EXPECT_EQ(make(0.5, 0.2).sample_li({0, 0, -1e-170}, {}).reason, NoLight::kOutOfRange);
}

TEST(SpotLight, CreateNamesFieldValueAndAllowedRange) {
  const auto error = [](const SpotLightParams& params) {
    return std::string(SpotLight::create(params).status().message());
  };
  EXPECT_EQ(error(spot(3.5, 1)), "spot.cone_half_angle = 3.5 rad, allowed (0, pi]");
  EXPECT_EQ(error(spot(0, 0)), "spot.cone_half_angle = 0 rad, allowed (0, pi]");
  EXPECT_EQ(error(spot(NAN, 0)), "spot.cone_half_angle = nan rad, allowed (0, pi]");
  EXPECT_EQ(error(spot(0.5, 0.75)),
            "spot.falloff_start = 0.75 rad, allowed [0, 0.5], the cone's half angle");
  EXPECT_THAT(error(spot(0.5, -0.1)), HasSubstr("spot.falloff_start = -0.1 rad"));
  EXPECT_THAT(error(spot(0.5, NAN)), HasSubstr("spot.falloff_start = nan rad"));
  auto params = spot(0.5, 0.2);
  params.axis = {};
  EXPECT_EQ(error(params), "spot.axis = (0, 0, 0), allowed: finite, of any length but 0");
  params = spot(0.5, 0.2);
  params.position_m.x = INFINITY;
  EXPECT_THAT(error(params), HasSubstr("spot.position = (inf, 0, 0) m"));
  params = spot(0.5, 0.2);
  params.intensity_cd.b = -1;
  EXPECT_THAT(error(params), HasSubstr("spot.intensity = (1, 1, -1) cd"));
}

// The textbook's spot of 30 degrees with an edge of 5: 2 pi (1 - (cos 25 + cos 30) / 2) = 0.715236
// sr for either profile.  x^4 integrates to 2 pi ((1 - cos 25) + (cos 25 - cos 30) / 5) = 0.639306
// sr.
TEST(SpotLight, TextbookPowerOfTheQuarticProfileStatesItsError) {
  constexpr double kRad = std::numbers::pi / 180;
  SpotLightParams params{.intensity_cd = Rgb(1),
                         .cone_half_angle_rad = 30 * kRad,
                         .falloff_start_rad = 25 * kRad,
                         .profile = SpotProfile::kQuartic};
  const auto quartic = *SpotLight::create(params);
  const double cos25 = 0.9063077870366499, cos30 = 0.8660254037844386;
  const double exact = 2 * std::numbers::pi * (1 - cos25 + (cos25 - cos30) / 5);
  const double books = 2 * std::numbers::pi * (1 - (cos25 + cos30) / 2);
  EXPECT_NEAR(quartic.power({}).lumens.g, exact, 1e-12);
  EXPECT_EQ(quartic.power({}).error_lumens, 0);
  const Power approximate = quartic.power_approximate({});
  EXPECT_NEAR(approximate.lumens.g, books, 1e-12);
  EXPECT_NEAR(approximate.error_lumens, books - exact, 1e-12);
  EXPECT_NEAR(books / exact, 1.12, 0.005);
  params.profile = SpotProfile::kSmoothstep;
  const auto smooth = *SpotLight::create(params);
  EXPECT_NEAR(smooth.power({}).lumens.g, books, 1e-12);
  EXPECT_LE(smooth.power_approximate({}).error_lumens, 1e-15);
}

// Through the narrowest cones, all rays keep the light's power, in float too.
TEST(SpotLight, RaysOfTheNarrowestConesCarryTheWholePower) {
  for (const double degrees : {1., 0.05, 0.01, 1e-5}) {
    const double cone = degrees * std::numbers::pi / 180;
    const auto light = *SpotLight::create({.axis = {1, 2, 3},
                                           .intensity_cd = Rgb(2),
                                           .cone_half_angle_rad = cone,
                                           .falloff_start_rad = cone / 2});
    const double power = light.power({}).lumens.g;
    for (int i = 0; i < 16; ++i) {
      const auto s = light.sample_le({}, {(i + 0.5) / 16, 0.3}, {});
      ASSERT_EQ(s.reason, NoLight::kNone);
      EXPECT_NEAR(s.value.g / s.pdf_direction.per_sr / power, 1, 1e-6);
    }
  }
}

}  // namespace
}  // namespace lucerna

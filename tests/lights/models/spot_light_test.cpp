#include "lights/models/spot_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lights/maths/vec.h"
#include "tests/lights/sample_statistics.h"

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

}  // namespace
}  // namespace lucerna

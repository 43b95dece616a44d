#include "lights/models/sun_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/contract_irradiance.h"
#include "tests/lights/contract/delta_cases.h"

namespace lucerna::testing {
namespace {

/// Angular diameters in milliradians: a wide lamp, and half of the sky.
template <int kMilliradians>
struct SunCase : CaseDefaults, SceneDiskCase {
  static constexpr double kHalf = kMilliradians * 0.5e-3;
  using Light = SunLight;
  static Vec3 to_light() { return {1, 2, 2}; }
  static SunLight make(const Placement& placement) {
    return *SunLight::create({.to_light = placement.direction(to_light()),
                              .angular_diameter_rad = kMilliradians * 1e-3,
                              .illuminance_lx = kDeltaLevel});
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {1e6, -3, 5}}; }
  static Region region(const Vec3&) { return {normalized(to_light()), kHalf}; }
  static Region emission_region(const Vec3&) { return {-normalized(to_light()), kHalf}; }
  /// The radiance whose illuminance is the level: rings of the disk, weighted with their cosine.
  static Rgb radiance() {
    return kDeltaLevel * (1 / simpson(0, kHalf, 2000, [](double t) {
                            return 2 * kPi * std::sin(t) * std::cos(t);
                          }));
  }
  static Rgb value(const Vec3&, const Vec3& wi) {
    const Vec3 a = to_light();
    const double angle = std::atan2(length(cross(a, wi)), dot(a, wi));
    return angle <= kHalf + 1e-6 ? radiance() : Rgb{};
  }
  /// For each direction, the flux through its disk of radius 4.
  static Rgb power_by_quadrature() {
    return radiance() *
           (16 * kPi * simpson(0, kHalf, 2000, [](double t) { return 2 * kPi * std::sin(t); }));
  }
};
using SunCases = ::testing::Types<SunCase<200>, SunCase<3000>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, AnyLight, SunCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, LightWithIrradiance, SunCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, LightWithDensity, SunCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, EmittingLight, SunCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, EmittingSurface, SunCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, EmittingDirections, SunCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sun, UnboundedLight, SunCases);

/// The illuminance on a surface that faces the centre, by the midpoints of a grid of samples.
double facing(const SunLight& sun, const Vec3& to_light) {
  double sum = 0;
  for (int i = 0; i < 64 * 64; ++i) {
    const auto s = sun.sample_li({0, 0, 0}, {(i / 64 + 0.5) / 64, (i % 64 + 0.5) / 64});
    sum += s.value.g * dot(to_light, Vec3(s.wi)) / s.pdf.per_sr;
    EXPECT_EQ(sun.le_escaped({}, s.wi), s.value);
    EXPECT_EQ(sun.pdf_li({0, 0, 0}, s.wi), s.pdf);
  }
  return sum / (64 * 64);
}

TEST(SunLight, GivesItsIlluminanceAtEveryAngularDiameter) {
  const Vec3 to_light = normalized(Vec3{1, -2, 3});
  // The real sun has an angular diameter of 0.0093 rad.
  for (const double diameter : {3.14159, 1., 0.0093, 1e-4, 1e-6, 1e-7}) {
    const auto sun = *SunLight::create({to_light, diameter, Rgb(100)});
    EXPECT_NEAR(facing(sun, to_light), 100, 2e-3) << diameter;
  }
}

TEST(SunLight, IsDarkBesideItsDisk) {
  const auto sun = *SunLight::create({{0, 0, 1}, 0.01, Rgb(1)});
  const auto at = [](double angle) { return Vec3{std::sin(angle), 0, std::cos(angle)}; };
  EXPECT_FALSE(sun.le_escaped({}, at(0.00499)).is_black());
  EXPECT_TRUE(sun.le_escaped({}, at(0.00501)).is_black());
  EXPECT_EQ(sun.pdf_li({0, 0, 0}, at(0.00501)).per_sr, 0);
  EXPECT_EQ(sun.pdf_li({0, 0, 0}, {NAN, 0, 1}).per_sr, 0);
}

TEST(SunLight, RefusesParametersOutsideTheirDomain) {
  const auto error = [](const SunLightParams& p) {
    return std::string(SunLight::create(p).status().message());
  };
  EXPECT_EQ(error({{0, 0, 1}, 0, Rgb(1)}), "sun.angular_diameter = 0 rad, allowed (0, pi]");
  EXPECT_THAT(error({{0, 0, 1}, 3.2, Rgb(1)}), ::testing::HasSubstr("= 3.2 rad"));
  EXPECT_THAT(error({{0, 0, 1}, NAN, Rgb(1)}), ::testing::HasSubstr("= nan rad"));
  EXPECT_THAT(error({{0, 0, 0}, 1, Rgb(1)}), ::testing::HasSubstr("sun.to_light"));
  EXPECT_THAT(error({{0, 0, 1}, 1, Rgb(-1)}), ::testing::HasSubstr("sun.illuminance"));
  EXPECT_THAT(error({{0, 0, 1}, 1e-160, Rgb(1e5)}), ::testing::HasSubstr("sin^2"));
}

}  // namespace
}  // namespace lucerna::testing

#include "lights/models/point_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "tests/lights/contract/contract_checks.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

PointLight light_at(const Vec3& position, double intensity) {
  return *PointLight::create({.position_m = position, .intensity_cd = Rgb(intensity)});
}

TEST(PointLight, PositionIsKeptAboutTheOrigin) {
  const Vec3 far{1e7, -1e7, 1e7};
  const auto light = *PointLight::create(
      {.position_m = far + Vec3{0.125, 0.25, 0.5}, .intensity_cd = Rgb(1)}, far);
  EXPECT_EQ(light.sample_li({0, 0, 0}, {}).point, Vec3(0.125, 0.25, 0.5));
}

TEST(PointLight, LightWithoutIntensityIsBlack) {
  const auto s = light_at({0, 0, 1}, 0).sample_li({0, 0, 0}, {});
  EXPECT_EQ(s.reason, NoLight::kBlack);
  EXPECT_TRUE(s.value.is_black());
}

TEST(PointLight, ValuesThatADoubleCannotHoldAreOutOfRangeOrZero) {
  EXPECT_EQ(light_at({}, 1).sample_li({1e-160, 0, 0}, {}).reason, NoLight::kOutOfRange);
  const auto faint = light_at({}, 1).sample_li({1e170, 0, 0}, {});
  EXPECT_EQ(faint.reason, NoLight::kNone);
  EXPECT_EQ(faint.value, Rgb(0));
  // Both coordinates fit a double, their distance does not.
  const auto s = light_at({-1e308, 0, 0}, 1e308).sample_li({1e308, 0, 0}, {});
  EXPECT_EQ(s.reason, NoLight::kOutOfRange);
  EXPECT_TRUE(testing::check_well_formed(s).ok());
}

/// Converts a plain sample to a sample; no plain sample becomes one without light.
std::optional<LightSample> plain_sample(const PointLight& light, const Vec3& receiver) {
  const auto plain = light.plain_sample_li(receiver);
  if (!plain) return std::nullopt;
  LightSample s;
  s.delta = true;
  s.wi = plain->wi, s.distance = plain->distance, s.value = plain->value;
  s.point = light.position();
  return s;
}

void expect_same_bits(const LightSample& a, const LightSample& b, double at) {
  EXPECT_EQ(a.reason, b.reason) << at;
  EXPECT_EQ(a.value, b.value) << at;
  EXPECT_EQ(a.wi, b.wi) << at;
  EXPECT_EQ(a.distance, b.distance) << at;
  EXPECT_EQ(a.point, b.point) << at;
  EXPECT_EQ(a.delta, b.delta) << at;
}

TEST(PointLight, PlainSamplesHaveTheBitsOfSamples) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> component(-1, 1);
  const auto light =
      *PointLight::create({.position_m = {1, -2, 0.5}, .intensity_cd = {1, 20, 300}});
  int plain = 0, all = 0;
  for (double size = 1e-300; size <= 1e300; size *= 10)
    for (int k = 0; k < 20; ++k) {
      const Vec3 v{component(random), component(random), component(random)};
      const Vec3 receiver(v * size);
      const auto s = plain_sample(light, receiver);
      if (s) expect_same_bits(*s, light.sample_li(receiver, {}), size);
      if (size >= 1e-6 && size <= 1e6) ++all, plain += s ? 1 : 0;
    }
  EXPECT_EQ(plain, all);  // where no special case applies
  for (const double no : {double(NAN), double(INFINITY)})
    EXPECT_FALSE(light.plain_sample_li({1, no, 0}));
  EXPECT_FALSE(light.plain_sample_li(light.position()));
}

TEST(PointLight, PlainSamplesExistOnlyWithinTheRangeOfNumbers) {
  const auto at_zero = [](double intensity) {
    return *PointLight::create({.position_m = {}, .intensity_cd = Rgb(intensity)});
  };
  EXPECT_FALSE(at_zero(0).plain_sample_li({0, 0, 1}));
  EXPECT_FALSE(at_zero(1e-300).plain_sample_li({0, 0, 1e30}));  // underflows
  EXPECT_FALSE(at_zero(1e300).plain_sample_li({0, 0, 1e-30}));  // overflows
  EXPECT_FALSE(at_zero(1).plain_sample_li({0, 0, 1e-150}));     // the square has lost digits
  EXPECT_FALSE(at_zero(1e300).plain_sample_li({0, 0, 1e160}));  // the square overflows
  EXPECT_TRUE(at_zero(1).plain_sample_li({0, 0, 1e-130}));
}

TEST(PointLight, CreateNamesFieldValueAndAllowedRange) {
  const auto error = [](const PointLightParams& params) {
    return std::string(PointLight::create(params).status().message());
  };
  const Rgb one(1);
  EXPECT_EQ(error({.intensity_cd = {1, -2, 1}}),
            "point.intensity = (1, -2, 1) cd, allowed: each channel finite, from 0 to 1.8e+308");
  EXPECT_EQ(
      error({.position_m = {0, NAN, 0}, .intensity_cd = one}),
      "point.position = (0, nan, 0) m, allowed: finite, within 1.8e+308 m of the scene's origin");
  EXPECT_THAT(error({.position_m = {INFINITY, 0, 0}, .intensity_cd = one}), HasSubstr("inf"));
  EXPECT_THAT(error({.intensity_cd = {NAN, 0, 0}}), HasSubstr("nan"));
  EXPECT_THAT(error({.intensity_cd = {0, INFINITY, 0}}), HasSubstr("inf"));
  EXPECT_TRUE(PointLight::create({.intensity_cd = {0, 0, 1e39}}).ok());
}

}  // namespace
}  // namespace lucerna

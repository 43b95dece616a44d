#include "lights/point_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/lights/contract_checks.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

PointLight<float> light_at(const Vec3<double>& position, double intensity) {
  return *PointLight<float>::create(
      {.position_m = position, .intensity_cd = Rgb<double>(intensity)});
}

TEST(PointLight, SampleIsIntensityOverDistanceSquared) {
  const auto light =
      *PointLight<float>::create({.position_m = {0, 0, 3}, .intensity_cd = {18, 9, 36}});
  const auto s = light.sample_li({0, 4, 0}, {0.5F, 0.5F});
  EXPECT_EQ(s.reason, NoLight::kNone);
  EXPECT_TRUE(s.delta);
  EXPECT_EQ(s.distance, 5);
  EXPECT_EQ(s.value, Rgb<float>(0.72F, 0.36F, 1.44F));
  EXPECT_EQ(s.wi, Vec3<float>(0, -0.8F, 0.6F));
  EXPECT_EQ(s.point, Vec3<float>(0, 0, 3));
  EXPECT_EQ(s.normal, Vec3<float>());
  EXPECT_EQ(s.pdf.per_sr, 0);
}

TEST(PointLight, PositionIsKeptAboutTheOrigin) {
  const Vec3<double> far{1e7, -1e7, 1e7};
  const auto light = *PointLight<float>::create(
      {.position_m = far + Vec3<double>{0.125, 0.25, 0.5}, .intensity_cd = Rgb<double>(1)}, far);
  EXPECT_EQ(light.sample_li({0, 0, 0}, {}).point, Vec3<float>(0.125F, 0.25F, 0.5F));
}

TEST(PointLight, PowerIsFourPiTimesIntensity) {
  EXPECT_DOUBLE_EQ(light_at({}, 1).power({}).lumens.g, 12.566370614359172);
  EXPECT_EQ(light_at({}, 1).power({}).error_lumens, 0);
}

TEST(PointLight, ReceiverOnTheLightIsDegenerate) {
  // 0.1 is no float: the light counts as where float puts it.
  const auto s = light_at({0.1, 0.2, 0.3}, 1).sample_li({0.1F, 0.2F, 0.3F}, {});
  EXPECT_EQ(s.reason, NoLight::kDegenerate);
  EXPECT_TRUE(s.value.is_black());
}

TEST(PointLight, LightWithoutIntensityIsBlack) {
  const auto s = light_at({0, 0, 1}, 0).sample_li({0, 0, 0}, {});
  EXPECT_EQ(s.reason, NoLight::kBlack);
  EXPECT_TRUE(s.value.is_black());
}

// Distances whose squares float cannot hold; quotients that it can.
TEST(PointLight, DistancesFrom1e23ThTo1e19AreExact) {
  struct Row {
    float distance;
    double intensity;
  };
  for (const Row row : {Row{1e-23F, 1e-20},
                        {1e-20F, 1e-10},
                        {1e-10F, 1},
                        {1e10F, 1},
                        {1e19F, 1e3},
                        {1e30F, 1e30},
                        {1e37F, 1e37}}) {
    const auto s = light_at({}, row.intensity).sample_li({0, row.distance, 0}, {});
    EXPECT_EQ(s.reason, NoLight::kNone) << row.distance;
    const long double expected =
        static_cast<long double>(row.intensity) / row.distance / row.distance;
    EXPECT_NEAR(double(s.value.r / expected), 1, 1e-7) << row.distance;
    EXPECT_EQ(s.distance, row.distance);
    EXPECT_EQ(s.wi, Vec3<float>(0, -1, 0));
  }
}

TEST(PointLight, ValuesThatFloatCannotHoldAreOutOfRangeOrZero) {
  EXPECT_EQ(light_at({}, 1).sample_li({1e-23F, 0, 0}, {}).reason, NoLight::kOutOfRange);
  const auto faint = light_at({}, 1).sample_li({1e30F, 0, 0}, {});
  EXPECT_EQ(faint.reason, NoLight::kNone);
  EXPECT_EQ(faint.value, Rgb<float>(0));
  // Both coordinates fit, their distance does not.
  const auto s = light_at({-3e38, 0, 0}, 3e38).sample_li({3e38F, 0, 0}, {});
  EXPECT_EQ(s.reason, NoLight::kOutOfRange);
  EXPECT_TRUE(testing::check_well_formed(s).ok());
}

TEST(PointLight, CreateNamesFieldValueAndWhatIsAllowed) {
  const auto error = [](const PointLightParams& params) {
    return std::string(PointLight<float>::create(params).status().message());
  };
  const Rgb<double> one(1);
  EXPECT_EQ(error({.intensity_cd = {1, -2, 1}}),
            "point.intensity = (1, -2, 1) cd, allowed: each channel finite, from 0 to 3.4e+38");
  EXPECT_EQ(
      error({.position_m = {0, NAN, 0}, .intensity_cd = one}),
      "point.position = (0, nan, 0) m, allowed: finite, within 3.4e+38 m of the scene's origin");
  EXPECT_THAT(error({.position_m = {1e39, 0, 0}, .intensity_cd = one}), HasSubstr("1e+39"));
  EXPECT_THAT(error({.intensity_cd = {NAN, 0, 0}}), HasSubstr("nan"));
  EXPECT_THAT(error({.intensity_cd = {0, INFINITY, 0}}), HasSubstr("inf"));
  EXPECT_THAT(error({.intensity_cd = {0, 0, 1e39}}), HasSubstr("1e+39"));
  EXPECT_TRUE(PointLight<double>::create({.intensity_cd = {0, 0, 1e39}}).ok());
}

}  // namespace
}  // namespace lucerna

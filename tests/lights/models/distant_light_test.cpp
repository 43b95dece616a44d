#include "lights/models/distant_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace lucerna {
namespace {

using ::testing::HasSubstr;

TEST(DistantLight, SampleIsTheSameEverywhere) {
  const auto light =
      *DistantLight<float>::create({.to_light = {0, 30, 40}, .illuminance_lx = {1, 2, 3}});
  for (const Vec3<float>& receiver : {Vec3<float>{0, 0, 0}, {1e30F, -5, 1e-30F}}) {
    const auto s = light.sample_li(receiver, {0, 1});
    EXPECT_EQ(s.reason, NoLight::kNone);
    EXPECT_TRUE(s.delta);
    EXPECT_EQ(s.wi, Vec3<float>(0, 0.6F, 0.8F));
    EXPECT_EQ(s.value, Rgb<float>(1, 2, 3));
    EXPECT_EQ(s.distance, INFINITY);
  }
}

TEST(DistantLight, DirectionMayHaveAnyLength) {
  for (const double l : {1e-300, 1e-30, 1., 1e30, 1e300}) {
    const auto light = DistantLight<float>::create(
        {.to_light = {0, 3 * l, 4 * l}, .illuminance_lx = Rgb<double>(1)});
    ASSERT_TRUE(light.ok());
    EXPECT_EQ(light->sample_li({}, {}).wi, Vec3<float>(0, 0.6F, 0.8F)) << l;
  }
}

// E pi R^2, by hand for E = 2 lx, R = 3 m: 18 pi.
TEST(DistantLight, PowerIsTheFluxThroughTheScenesDisk) {
  const auto light = *DistantLight<float>::create({.illuminance_lx = Rgb<double>(2)});
  EXPECT_DOUBLE_EQ(light.power({{5, 5, 5}, 3}).lumens.r, 56.548667764616276);
  EXPECT_EQ(light.power({{}, 0}).lumens.r, 0);
}

TEST(DistantLight, BlackLightHasNoPowerEvenWithoutBounds) {
  const auto light = *DistantLight<float>::create({.illuminance_lx = {}});
  EXPECT_EQ(light.sample_li({}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(light.power({{}, INFINITY}).lumens, Rgb<double>());
}

TEST(DistantLight, CreateNamesFieldValueAndAllowedRange) {
  const auto error = [](const DistantLightParams& params) {
    return std::string(DistantLight<float>::create(params).status().message());
  };
  EXPECT_EQ(error({.to_light = {0, 0, 0}, .illuminance_lx = Rgb<double>(1)}),
            "distant.to_light = (0, 0, 0), allowed: finite, of any length but 0");
  EXPECT_THAT(error({.to_light = {NAN, 0, 0}, .illuminance_lx = Rgb<double>(1)}), HasSubstr("nan"));
  EXPECT_EQ(error({.illuminance_lx = {0, -1, 0}}),
            "distant.illuminance = (0, -1, 0) lx, allowed: each channel finite, from 0 to 3.4e+38");
}

}  // namespace
}  // namespace lucerna

#include "lights/models/distant_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace lucerna {
namespace {

using ::testing::HasSubstr;

TEST(DistantLight, SampleIsTheSameEverywhere) {
  const auto light = *DistantLight::create({.to_light = {0, 30, 40}, .illuminance_lx = {1, 2, 3}});
  for (const Vec3& receiver : {Vec3{0, 0, 0}, {1e30, -5, 1e-30}}) {
    const auto s = light.sample_li(receiver, {0, 1});
    EXPECT_EQ(s.reason, NoLight::kNone);
    EXPECT_TRUE(s.delta);
    EXPECT_EQ(s.wi, Vec3(0, 0.6, 0.8));
    EXPECT_EQ(s.value, Rgb(1, 2, 3));
    EXPECT_EQ(s.distance, INFINITY);
  }
}

TEST(DistantLight, DirectionMayHaveAnyLength) {
  for (const double l : {1e-300, 1e-30, 1., 1e30, 1e300}) {
    const auto light =
        DistantLight::create({.to_light = {0, 3 * l, 4 * l}, .illuminance_lx = Rgb(1)});
    ASSERT_TRUE(light.ok());
    const Vec3 wi = light->sample_li({}, {}).wi;
    EXPECT_EQ(wi.x, 0) << l;
    EXPECT_DOUBLE_EQ(wi.y, 0.6) << l;
    EXPECT_DOUBLE_EQ(wi.z, 0.8) << l;
  }
}

TEST(DistantLight, BlackLightHasNoPowerEvenWithoutBounds) {
  const auto light = *DistantLight::create({.illuminance_lx = {}});
  EXPECT_EQ(light.sample_li({}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(light.power({{}, INFINITY}).lumens, Rgb());
}

TEST(DistantLight, CreateNamesFieldValueAndAllowedRange) {
  const auto error = [](const DistantLightParams& params) {
    return std::string(DistantLight::create(params).status().message());
  };
  EXPECT_EQ(error({.to_light = {0, 0, 0}, .illuminance_lx = Rgb(1)}),
            "distant.to_light = (0, 0, 0), allowed: finite, of any length but 0");
  EXPECT_THAT(error({.to_light = {NAN, 0, 0}, .illuminance_lx = Rgb(1)}), HasSubstr("nan"));
  EXPECT_EQ(
      error({.illuminance_lx = {0, -1, 0}}),
      "distant.illuminance = (0, -1, 0) lx, allowed: each channel finite, from 0 to 1.8e+308");
}

}  // namespace
}  // namespace lucerna

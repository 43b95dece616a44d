#include "lights/models/infinite_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

UniformInfiniteLight light_of(double radiance) {
  return *UniformInfiniteLight::create({.radiance_cd_m2 = Rgb(radiance)});
}

TEST(UniformInfiniteLight, DensityIsOneOverFourPiInEveryDirection) {
  const auto light = light_of(1);
  EXPECT_DOUBLE_EQ(light.pdf_li({0, 0, 0}, {0, 0, 1}).per_sr, 1 / (4 * kPi));
  EXPECT_DOUBLE_EQ(light.pdf_li({1, 2, 3}, {0.6, -0.8, 0}).per_sr, 1 / (4 * kPi));
  EXPECT_DOUBLE_EQ(light.sample_li({}, {0.3, 0.7}).pdf.per_sr, 1 / (4 * kPi));
  EXPECT_EQ(light.pdf_li({}, {NAN, 0, 0}).per_sr, 0);
}

TEST(UniformInfiniteLight, EscapedRaysMeetItsRadiance) {
  const auto light = *UniformInfiniteLight::create({.radiance_cd_m2 = {1, 2, 3}});
  EXPECT_EQ(light.le_escaped({5, 6, 7}, {0, 1, 0}), Rgb(1, 2, 3));
}

TEST(UniformInfiniteLight, BlackLightGivesItsReasonAndHasNoPowerEvenWithoutBounds) {
  const auto light = light_of(0);
  EXPECT_EQ(light.sample_li({}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(light.pdf_li({}, {0, 0, 1}).per_sr, 0);
  EXPECT_EQ(light.power({{}, INFINITY}).lumens, Rgb());
}

TEST(UniformInfiniteLight, CreateNamesFieldValueAndAllowedRange) {
  const auto status = UniformInfiniteLight::create({.radiance_cd_m2 = {1, INFINITY, 1}}).status();
  EXPECT_EQ(std::string(status.message()),
            "infinite.radiance = (1, inf, 1) cd/m2, allowed: each channel finite, from 0 to "
            "1.8e+308");
  EXPECT_FALSE(UniformInfiniteLight::create({.radiance_cd_m2 = {NAN, 1, 1}}).ok());
  EXPECT_FALSE(UniformInfiniteLight::create({.radiance_cd_m2 = {1, 1, -1e-30}}).ok());
}

}  // namespace
}  // namespace lucerna

#include "lights/models/sun_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace lucerna::testing {
namespace {

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

#include "lights/models/beam_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace lucerna {
namespace {

using ::testing::HasSubstr;

constexpr SceneSphere kScene{{}, 1};

BeamLightParams beam() { return {.width_m = 2, .height_m = 1, .illuminance_lx = Rgb(10)}; }

TEST(BeamLight, IlluminatesThePrismBeforeItsRectangleAtAnyDistance) {
  const auto l = *BeamLight::create(beam());
  for (const float z : {1e-6, 1.0, 1e6}) {
    const auto s = l.sample_li({0.99, -0.49, z}, {});
    EXPECT_EQ(s.value, Rgb(10));
    EXPECT_EQ(s.wi, Vec3(0, 0, -1));
    EXPECT_EQ(s.distance, z);
    EXPECT_EQ(s.point, Vec3(0.99, -0.49, 0));
    EXPECT_EQ(l.sample_li({1.01, 0, z}, {}).reason, NoLight::kOutsideCone);
    EXPECT_EQ(l.sample_li({0, 0.51, z}, {}).reason, NoLight::kOutsideCone);
    EXPECT_EQ(l.sample_li({0, 0, -z}, {}).reason, NoLight::kBehind);
  }
  EXPECT_EQ(l.sample_li({0, 0, 0}, {}).reason, NoLight::kBehind);
  // The edge belongs to the rectangle.
  EXPECT_EQ(l.sample_li({1, 0.5, 2}, {}).reason, NoLight::kNone);
}

// Far from the scene's origin, the coordinates of a float are coarser than the rectangle.
TEST(BeamLight, KeepsItsRaysWhereTheRectangleIsNarrowerThanARounding) {
  auto p = beam();
  p.position_m = {1e5, -1e5, 1e5};
  p.width_m = p.height_m = 1e-4;
  const auto l = *BeamLight::create(p);
  for (const float u : {0.0, 0.3, 1.0}) {
    const auto s = l.sample_le({u, 1 - u}, {}, kScene);
    EXPECT_EQ(s.reason, NoLight::kNone);
    EXPECT_DOUBLE_EQ(s.pdf_position.per_m2, 1e8);
    EXPECT_EQ(l.pdf_le(s.origin, s.direction, kScene).position, s.pdf_position);
  }
}

TEST(BeamLight, GivesTheReasonForNoLight) {
  auto p = beam();
  p.image = *Image::create(2, 1, {Rgbf(0), Rgbf(1)});
  const auto l = *BeamLight::create(p);
  EXPECT_EQ(l.sample_li({-0.5, 0, 1}, {}).reason, NoLight::kOutsideCone);
  p.image = *Image::create(1, 1, {Rgbf(0)});
  const auto black = *BeamLight::create(p);
  EXPECT_EQ(black.sample_li({0, 0, 1}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(black.sample_le({0.5, 0.5}, {}, kScene).reason, NoLight::kBlack);
  EXPECT_EQ(black.pdf_le({}, {0, 0, 1}, kScene), EmissionPdf{});
  EXPECT_EQ(black.power(kScene).lumens, Rgb());
}

TEST(BeamLight, BoxHoldsTheCornersOfATurnedRectangle) {
  auto p = beam();
  p.position_m = {1, 2, 3};
  p.axes = {{1, 1, 0}, {0, 0, 5}, {1, -1, 0}};
  const auto [lower, upper] = bounding_box(p);
  const double s = std::sqrt(0.5);
  EXPECT_NEAR(lower.x, 1 - s, 1e-15);
  EXPECT_NEAR(upper.y, 2 + s, 1e-15);
  EXPECT_NEAR(lower.z, 2.5, 1e-15);
  EXPECT_NEAR(upper.z, 3.5, 1e-15);
}

TEST(BeamLight, CreateNamesTheInvalidParameter) {
  const auto error = [](const auto& change) {
    BeamLightParams p = beam();
    change(p);
    return std::string(BeamLight::create(p).status().message());
  };
  EXPECT_EQ(error([](auto&) {}), "");
  for (const double side : {0.0, -1.0, 1e200, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(error([&](auto& p) { p.width_m = side; }), HasSubstr("beam.width and height"));
    EXPECT_THAT(error([&](auto& p) { p.height_m = side; }), HasSubstr("beam.width and height"));
  }
  EXPECT_THAT(error([](auto& p) { p.axes.s = {1, 0, 1}; }), HasSubstr("at right angles"));
  EXPECT_THAT(error([](auto& p) { p.illuminance_lx.r = -1; }), HasSubstr("beam.illuminance = (-1"));
  EXPECT_THAT(error([](auto& p) { p.position_m.y = INFINITY; }), HasSubstr("beam.position"));
  EXPECT_THAT(error([](auto& p) {
                p.image = *Image::create(1, 1, {Rgbf(1e38)}), p.illuminance_lx = Rgb(1e300);
              }),
              HasSubstr("brightest texel"));
}

}  // namespace
}  // namespace lucerna

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

BeamLightParams beam() { return {.width_m = 2, .height_m = 1, .illuminance_lx = Rgb<double>(10)}; }

TEST(BeamLight, IlluminatesThePrismBeforeItsRectangleAtAnyDistance) {
  const auto l = *BeamLight<float>::create(beam());
  for (const float z : {1e-6F, 1.F, 1e6F}) {
    const auto s = l.sample_li({0.99F, -0.49F, z}, {});
    EXPECT_EQ(s.value, Rgb<float>(10));
    EXPECT_EQ(s.wi, Vec3<float>(0, 0, -1));
    EXPECT_EQ(s.distance, z);
    EXPECT_EQ(s.point, Vec3<float>(0.99F, -0.49F, 0));
    EXPECT_EQ(l.sample_li({1.01F, 0, z}, {}).reason, NoLight::kOutsideCone);
    EXPECT_EQ(l.sample_li({0, 0.51F, z}, {}).reason, NoLight::kOutsideCone);
    EXPECT_EQ(l.sample_li({0, 0, -z}, {}).reason, NoLight::kBehind);
  }
  EXPECT_EQ(l.sample_li({0, 0, 0}, {}).reason, NoLight::kBehind);
  // The edge belongs to the rectangle.
  EXPECT_EQ(l.sample_li({1, 0.5F, 2}, {}).reason, NoLight::kNone);
}

TEST(BeamLight, UpperLeftOfThePictureIsUpAndLeft) {
  auto p = beam();
  p.image = *Image::create(2, 2, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}});
  const auto l = *BeamLight<double>::create(p);
  EXPECT_EQ(l.sample_li({-0.5, 0.25, 1}, {}).value, Rgb<double>(10, 0, 0));
  EXPECT_EQ(l.sample_li({0.5, 0.25, 1}, {}).value, Rgb<double>(0, 10, 0));
  EXPECT_EQ(l.sample_li({-0.5, -0.25, 1}, {}).value, Rgb<double>(0, 0, 10));
  EXPECT_EQ(l.sample_li({0.5, -0.25, 1}, {}).value, Rgb<double>(10));
  // E A times the mean of each channel, a half.
  EXPECT_EQ(l.power(kScene).lumens, Rgb<double>(10));
  EXPECT_EQ(l.power(kScene).error_lumens, 0);
}

// Far from the scene's origin, the coordinates of a float are coarser than the rectangle.
TEST(BeamLight, KeepsItsRaysWhereTheRectangleIsNarrowerThanARounding) {
  auto p = beam();
  p.position_m = {1e5, -1e5, 1e5};
  p.width_m = p.height_m = 1e-4;
  const auto l = *BeamLight<float>::create(p);
  for (const float u : {0.F, 0.3F, 1.F}) {
    const auto s = l.sample_le({u, 1 - u}, {}, kScene);
    EXPECT_EQ(s.reason, NoLight::kNone);
    EXPECT_FLOAT_EQ(s.pdf_position.per_m2, 1e8F);
    EXPECT_EQ(l.pdf_le(s.origin, s.direction, kScene).position, s.pdf_position);
  }
}

TEST(BeamLight, GivesTheReasonForNoLight) {
  auto p = beam();
  p.image = *Image::create(2, 1, {Rgb<float>(0), Rgb<float>(1)});
  const auto l = *BeamLight<float>::create(p);
  EXPECT_EQ(l.sample_li({-0.5F, 0, 1}, {}).reason, NoLight::kOutsideCone);
  p.image = *Image::create(1, 1, {Rgb<float>(0)});
  const auto black = *BeamLight<float>::create(p);
  EXPECT_EQ(black.sample_li({0, 0, 1}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(black.sample_le({0.5F, 0.5F}, {}, kScene).reason, NoLight::kBlack);
  EXPECT_EQ(black.pdf_le({}, {0, 0, 1}, kScene), EmissionPdf<float>{});
  EXPECT_EQ(black.power(kScene).lumens, Rgb<double>());
  // Below the range of float.
  p = beam();
  p.illuminance_lx = Rgb<double>(1e-50);
  const auto faint = *BeamLight<float>::create(p);
  EXPECT_EQ(faint.sample_li({0, 0, 1}, {}).reason, NoLight::kNone);
  EXPECT_EQ(faint.sample_li({0, 0, 1}, {}).value, Rgb<float>());
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
    return std::string(BeamLight<float>::create(p).status().message());
  };
  EXPECT_EQ(error([](auto&) {}), "");
  for (const double side : {0.0, -1.0, 1e30, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(error([&](auto& p) { p.width_m = side; }), HasSubstr("beam.width and height"));
    EXPECT_THAT(error([&](auto& p) { p.height_m = side; }), HasSubstr("beam.width and height"));
  }
  EXPECT_THAT(error([](auto& p) { p.axes.s = {1, 0, 1}; }), HasSubstr("at right angles"));
  EXPECT_THAT(error([](auto& p) { p.illuminance_lx.r = -1; }), HasSubstr("beam.illuminance = (-1"));
  EXPECT_THAT(error([](auto& p) { p.position_m.y = 1e39; }), HasSubstr("beam.position"));
  EXPECT_THAT(error([](auto& p) { p.image = *Image::create(1, 1, {Rgb<float>(1e38F)}); }),
              HasSubstr("brightest texel"));
}

}  // namespace
}  // namespace lucerna

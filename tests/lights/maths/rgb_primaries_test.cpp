#include "lights/maths/rgb_primaries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lucerna {
namespace {

using White = RgbConversion::White;

Rgb converted(const char* space, White white, const Rgb& c) {
  return (*RgbConversion::to_rec709(*named_primaries(space), white))(c);
}

void expect_near(const Rgb& c, const Rgb& expected, double error) {
  EXPECT_NEAR(c.r, expected.r, error);
  EXPECT_NEAR(c.g, expected.g, error);
  EXPECT_NEAR(c.b, expected.b, error);
}

TEST(RgbPrimaries, Rec2020IsConvertedAsTheStandardSays) {
  // The matrix of [BT2087] from Rec. 2020 to Rec. 709, column by column.
  for (const White white : {White::kKept, White::kAdapted}) {
    expect_near(converted("rec2020", white, {1, 0, 0}), {1.6605, -0.1246, -0.0182}, 5e-5);
    expect_near(converted("rec2020", white, {0, 1, 0}), {-0.5876, 1.1329, -0.1006}, 5e-5);
    expect_near(converted("Rec2020", white, {0, 0, 1}), {-0.0728, -0.0083, 1.1187}, 5e-5);
  }
  // The luminances in [BT2020].
  EXPECT_NEAR(luminance(converted("rec2020", White::kKept, {1, 0, 0})), 0.2627, 5e-5);
  EXPECT_NEAR(luminance(converted("rec2020", White::kKept, {0, 1, 0})), 0.6780, 5e-5);
  EXPECT_NEAR(luminance(converted("rec2020", White::kKept, {0, 0, 1})), 0.0593, 5e-5);
}

TEST(RgbPrimaries, LightOfAnotherWhiteKeepsItsLuminanceAndItsTint) {
  // The Y row of SMPTE ST 2065-1.
  EXPECT_NEAR(luminance(converted("aces2065-1", White::kKept, {1, 0, 0})), 0.3439664498, 1e-9);
  EXPECT_NEAR(luminance(converted("aces2065-1", White::kKept, {0, 1, 0})), 0.7281660966, 1e-9);
  EXPECT_NEAR(luminance(converted("aces2065-1", White::kKept, {0, 0, 1})), -0.0721325464, 1e-9);
  const Rgb white = converted("aces2065-1", White::kKept, {1, 1, 1});
  EXPECT_NEAR(luminance(white), 1, 1e-12);
  EXPECT_GT(white.r, white.b);  // about 6000 K
}

TEST(RgbPrimaries, ReflectancesOfAnotherWhiteKeepWhite) {
  // ACES2065-1 to Rec. 709 by Bradford's transform, as published with ACES.
  expect_near(converted("ACES2065-1", White::kAdapted, {1, 0, 0}), {2.52169, -0.27648, -0.01538},
              2e-4);
  expect_near(converted("ACES2065-1", White::kAdapted, {0, 1, 0}), {-1.13413, 1.37272, -0.15298},
              2e-4);
  expect_near(converted("ACES2065-1", White::kAdapted, {1, 1, 1}), {1, 1, 1}, 1e-12);
}

TEST(RgbPrimaries, XyzBecomesTheColourOfTheseXyz) {
  const auto from_xyz = *RgbConversion::to_rec709(kXyz, White::kKept);
  expect_near(from_xyz({0.3127 / 0.3290, 1, 0.3583 / 0.3290}), {1, 1, 1}, 1e-12);
  // The red of Rec. 709.
  expect_near(from_xyz({0.412390799, 0.212639006, 0.019330819}), {1, 0, 0}, 1e-8);
}

TEST(RgbPrimaries, Rec709StaysAsItIs) {
  for (const White white : {White::kKept, White::kAdapted})
    expect_near(converted("srgb", white, {0.25, 3, 700}), {0.25, 3, 700}, 1e-10);
}

TEST(RgbPrimaries, PointsThatSpanNoSpaceAreRefused) {
  EXPECT_EQ(named_primaries("cmyk"), nullptr);
  EXPECT_EQ(named_primaries("srgb "), nullptr);
  const auto refused = [](const RgbPrimaries& p) {
    return !RgbConversion::to_rec709(p, White::kAdapted).has_value();
  };
  EXPECT_FALSE(refused(kRec709));
  RgbPrimaries p = kRec709;
  p.green = p.red;
  EXPECT_TRUE(refused(p));
  p = kRec709;
  p.white = {0.7, 0.3};  // outside of the triangle
  EXPECT_TRUE(refused(p));
  p = kRec709;
  p.white = {0.3, 0};
  EXPECT_TRUE(refused(p));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    p = kRec709;
    p.blue.x = bad;
    EXPECT_TRUE(refused(p)) << bad;
  }
  EXPECT_TRUE(refused({{0, 0}, {0, 0}, {0, 0}, {0, 0}}));
}

TEST(RgbPrimaries, ColoursOutsideKeepTheirLuminance) {
  const Rgb red{1.6605, -0.1246, -0.0182};
  EXPECT_TRUE(is_outside_rec709(red));
  const Rgb edge = at_edge_of_rec709(red);
  EXPECT_NEAR(luminance(edge), luminance(red), 1e-15);
  EXPECT_EQ(edge.g, 0);
  EXPECT_EQ(edge.b, 0);
  EXPECT_EQ(at_edge_of_rec709({-1, 0.1, 0}), Rgb());
  EXPECT_EQ(at_edge_of_rec709({1, 2, 3}), Rgb(1, 2, 3));
  EXPECT_FALSE(is_outside_rec709({1, -1e-9, 0}));
}

}  // namespace
}  // namespace lucerna

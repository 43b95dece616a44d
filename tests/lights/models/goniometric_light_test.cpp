#include "lights/models/goniometric_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lights/maths/vec.h"

namespace lucerna {
namespace {

using ::testing::HasSubstr;

/// 1 cd at gamma 0; at gamma 90 2 cd at C0, 3 at C90, 4 at C180, 5 at C270.
std::shared_ptr<const PhotometricWeb> compass() {
  return *PhotometricWeb::create({PhotometricType::kC,
                                  {0, 90, 180},
                                  {0, 90, 180, 270, 360},
                                  {1, 2, 0, 1, 3, 0, 1, 4, 0, 1, 5, 0, 1, 2, 0}});
}

std::shared_ptr<const IntensityMap> stripes(SphereMapping mapping, std::vector<float> rows) {
  std::vector<Rgbf> texels;
  const auto n = static_cast<int>(rows.size());
  for (const float row : rows)
    for (int x = 0; x < n; ++x) texels.emplace_back(row);
  return *IntensityMap::create(*Image::create(n, n, std::move(texels)), mapping,
                               ImageFilter::kNearest);
}

GoniometricLight light(const Frame& axes) {
  return *GoniometricLight::create({.axes = axes, .intensity = Rgb(1), .web = compass()});
}

std::string error(const GoniometricLightParams& params) {
  const auto made = GoniometricLight::create(params);
  return made.ok() ? "" : std::string(made.status().message());
}

TEST(GoniometricLight, ShinesAlongItsZAxisAndTurnsWithItsAxes) {
  const auto as_it_is = light({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  EXPECT_NEAR(as_it_is.intensity({0, 0, 1}).r, 1, 1e-12);
  EXPECT_NEAR(as_it_is.intensity({1, 0, 0}).r, 2, 1e-12);
  EXPECT_NEAR(as_it_is.intensity({0, -1, 0}).r, 3, 1e-12);
  EXPECT_NEAR(as_it_is.intensity({0, 1, 0}).r, 5, 1e-12);
  // Rotated about x by 180 degrees, it hangs in a world whose z is up.
  const auto hung = light({{3, 0, 0}, {0, -3, 0}, {0, 0, -3}});
  EXPECT_NEAR(hung.intensity({0, 0, -1}).r, 1, 1e-12);
  EXPECT_NEAR(hung.intensity({0, 1, 0}).r, 3, 1e-12);
  EXPECT_NEAR(hung.intensity({-1, 0, 0}).r, 4, 1e-12);
  // Mirrored: C90 and C270 swap places.
  const auto mirrored = light({{1, 0, 0}, {0, 1, 0}, {0, 0, -1}});
  EXPECT_NEAR(mirrored.intensity({0, 1, 0}).r, 5, 1e-12);
  EXPECT_NEAR(mirrored.intensity({0, -1, 0}).r, 3, 1e-12);
  EXPECT_NEAR(mirrored.intensity({0, 0, -1}).r, 1, 1e-12);
}

TEST(GoniometricLight, RefusesParametersOutsideTheirDomain) {
  const GoniometricLightParams good{.intensity = Rgb(1), .web = compass()};
  EXPECT_EQ(error(good), "");
  auto p = good;
  p.axes = {{1, 0, 0}, {0, 2, 0}, {0, 0, 1}};
  EXPECT_THAT(error(p), HasSubstr("goniometric.axes = (1, 0, 0), (0, 2, 0), (0, 0, 1), allowed"));
  p.axes = {{1, 0, 0}, {0.1, 1, 0}, {0, 0, 1}};
  EXPECT_THAT(error(p), HasSubstr("at right angles"));
  p.axes = {{1, 0, 0}, {0, 0, 0}, {0, 0, 1}};
  EXPECT_THAT(error(p), HasSubstr("of any length but 0"));
  p = good;
  p.intensity = {1, -1, 1};
  EXPECT_THAT(error(p), HasSubstr("goniometric.intensity = (1, -1, 1)"));
  p.intensity = Rgb(1e308);
  EXPECT_THAT(error(p), HasSubstr("times the largest of the file"));
  p.web = nullptr;
  EXPECT_EQ(error(p), "");
  p.map = stripes(SphereMapping::kEqualArea, {0, 4});
  EXPECT_THAT(error(p), HasSubstr("times the largest of the file"));
  p = good;
  p.map = stripes(SphereMapping::kEqualArea, {0, 4});
  EXPECT_THAT(error(p), HasSubstr("goniometric.web and goniometric.map, allowed: one of them"));
  p = good;
  p.position_m.x = NAN;
  EXPECT_THAT(error(p), HasSubstr("goniometric.position"));
}

// Rows of 60 degrees cover pi, 2 pi and pi sr; the mean texel counts each with 4 pi / 3.
TEST(GoniometricLight, TextbookPowerStatesItsError) {
  const auto belt = *GoniometricLight::create(
      {.intensity = {3, 3, 3}, .map = stripes(SphereMapping::kLatitudeLongitude, {0, 1, 0})});
  EXPECT_NEAR(luminance(belt.power({}).lumens), 6 * kPi, 1e-12);
  EXPECT_EQ(belt.power({}).error_lumens, 0);
  EXPECT_NEAR(luminance(belt.power_approximate({}).lumens), 4 * kPi, 1e-12);
  EXPECT_NEAR(belt.power_approximate({}).error_lumens, 2 * kPi, 1e-12);
  const auto equal = *GoniometricLight::create(
      {.intensity = {3, 3, 3}, .map = stripes(SphereMapping::kEqualArea, {0, 1, 0})});
  EXPECT_NEAR(luminance(equal.power({}).lumens), 4 * kPi, 1e-12);
  EXPECT_EQ(equal.power_approximate({}).lumens, equal.power({}).lumens);
  EXPECT_EQ(equal.power_approximate({}).error_lumens, 0);
}

TEST(GoniometricLight, AMapTurnsWithItsAxes) {
  // The rows of latitude and longitude: bright where the map's +y is.
  const auto up =
      *GoniometricLight::create({.axes = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
                                 .intensity = Rgb(1),
                                 .map = stripes(SphereMapping::kLatitudeLongitude, {9, 1, 0})});
  EXPECT_EQ(up.intensity({1, 0, 0}), Rgb(9));
  EXPECT_EQ(up.intensity({0, 0, 1}), Rgb(1));
  EXPECT_EQ(up.intensity({0, 1, 0}), Rgb(1));
  EXPECT_EQ(up.intensity({-1, 0, 0}), Rgb(0));
  EXPECT_EQ(up.sample_li({-1, 0, 0}, {}).reason, NoLight::kOutsideCone);
  EXPECT_NEAR(up.bounds()->axis.x, 1, 1e-15);
}

TEST(GoniometricLight, DarkDirectionsAndBlackLightsGiveTheirReason) {
  const auto down = *GoniometricLight::create(
      {.intensity = Rgb(1),
       .web = *PhotometricWeb::create({PhotometricType::kC, {0, 90}, {0}, {1, 1}})});
  EXPECT_EQ(down.sample_li(Vec3{0, 0, -1}, {}).reason, NoLight::kOutsideCone);
  EXPECT_EQ(down.sample_li(Vec3{0, 0, 1}, {}).reason, NoLight::kNone);
  const auto black = *GoniometricLight::create(
      {.intensity = Rgb(1),
       .web = *PhotometricWeb::create({PhotometricType::kC, {0, 90}, {0}, {0, 0}})});
  EXPECT_EQ(black.sample_li(Vec3{0, 0, 1}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(black.sample_le({}, {0.5, 0.5}, {}).reason, NoLight::kBlack);
  EXPECT_EQ(luminance(black.power({}).lumens), 0);
}

}  // namespace
}  // namespace lucerna

#include "lights/models/portal_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lights/maths/vec.h"
#include "tests/lights/sample_statistics.h"

namespace lucerna {
namespace {

using testing::RandomU;

/// Around [0, width] x [0, height] at `z`; light comes from above.
std::array<Vec3, 4> window(double width, double height, double z) {
  return {{{0, 0, z}, {0, height, z}, {width, height, z}, {width, 0, z}}};
}

PortalLight portal(const std::array<Vec3, 4>& corners,
                   std::shared_ptr<const SphereMap> map = nullptr) {
  return *PortalLight::create({.map = std::move(map), .corners_m = corners});
}

std::shared_ptr<const SphereMap> square_map(std::vector<Rgbf> texels) {
  const int n = static_cast<int>(std::lround(std::sqrt(double(texels.size()))));
  return *SphereMap::create(*Image::create(n, n, std::move(texels)), SphereMapping::kEqualArea,
                            ImageFilter::kNearest);
}

/// The illuminance on a surface that faces +z, from n samples, and its standard error.
struct Mean {
  double lx, error;
};
Mean illuminance(const PortalLight& light, const Vec3& receiver, int n) {
  RandomU random(7);
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const auto s = light.sample_li(receiver, random.pair());
    if (s.reason != NoLight::kNone) continue;
    const double x = double{luminance(s.value)} * s.wi.z / s.pdf.per_sr;
    sum += x;
    squares += x * x;
  }
  const double mean = sum / n;
  return {mean, std::sqrt(std::fmax(0, squares / n - mean * mean) / n)};
}

TEST(PortalLight, OnlyRaysThroughTheRectangleFromInsideMeetTheSky) {
  const auto light = portal(window(2, 3, 1));
  const Vec3 inside{1, 1, 0};
  const auto towards = [&](float x, float y) { return normalized(Vec3{x, y, 1} - inside); };
  EXPECT_EQ(light.le_escaped(inside, towards(0.001, 0.001)), Rgb(1));
  EXPECT_EQ(light.le_escaped(inside, towards(1.999, 2.999)), Rgb(1));
  for (const Vec3& w : {towards(-0.001, 1), towards(2.001, 1), towards(1, -0.001),
                        towards(1, 3.001), -towards(1, 1), Vec3{1, 0, 0}}) {
    EXPECT_TRUE(light.le_escaped(inside, w).is_black());
    EXPECT_EQ(light.pdf_li(inside, w).per_sr, 0);
  }
  // From the other side, outwards and inwards.
  EXPECT_TRUE(light.le_escaped({1, 1, 2}, {0, 0, 1}).is_black());
  EXPECT_TRUE(light.le_escaped({1, 1, 2}, {0, 0, -1}).is_black());
}

TEST(PortalLight, ReceiversThatDoNotSeeThePortalGetAReason) {
  const auto light = portal(window(2, 3, 1));
  const auto reason = [&](const Vec3& r) {
    const auto s = light.sample_li(r, {0.5, 0.5});
    EXPECT_TRUE(s.value.is_black());
    EXPECT_EQ(light.pdf_li(r, {0, 0, 1}).per_sr, 0);
    return s.reason;
  };
  EXPECT_EQ(reason({1, 1, 2}), NoLight::kBehind);
  EXPECT_EQ(reason({-1, 1, 1}), NoLight::kBehind);  // in its plane, beside it
  EXPECT_EQ(reason({1, 1, 1}), NoLight::kDegenerate);
  EXPECT_EQ(reason({0, 0, 1}), NoLight::kDegenerate);
  EXPECT_EQ(reason({NAN, 0, 0}), NoLight::kOutOfRange);
  // 1e-30 m below the plane the window covers the whole hemisphere.  The receiver still has an
  // answer.
  const auto near = portal(window(2, 3, 1e-30));
  EXPECT_NEAR(illuminance(near, Vec3(1, 1, 0), 100000).lx, kPi, 0.1);
}

TEST(PortalLight, PowerIsTheFluxThroughThePortalInAnyScene) {
  const auto light = portal(window(2, 3, 1));
  for (const SceneSphere& scene : {SceneSphere{}, SceneSphere{{1, 2, 3}, 1e6}}) {
    const Power power = light.power(scene);
    EXPECT_NEAR(power.lumens.r, kPi * 6, 1e-12);
    EXPECT_EQ(power.error_lumens, 0);
    const Power approximate = light.power_approximate(scene);
    EXPECT_NEAR(approximate.lumens.r, 2 * kPi * 6, 1e-12);
    EXPECT_NEAR(approximate.error_lumens, kPi * 6, 1e-9);
  }
}

TEST(PortalLight, BlackMapsAndBlackPartsGiveTheirReason) {
  const auto black = portal(window(2, 3, 1), square_map(std::vector<Rgbf>(16)));
  EXPECT_EQ(black.sample_li({1, 1, 0}, {0.5, 0.5}).reason, NoLight::kBlack);
  EXPECT_EQ(black.pdf_li({1, 1, 0}, {0, 0, 1}).per_sr, 0);
  EXPECT_EQ(black.sample_le({0.5, 0.5}, {0.5, 0.5}, {}).reason, NoLight::kBlack);
  EXPECT_TRUE(black.power({}).lumens.is_black());
  // Lit below the horizon only: no light comes through.
  std::vector<Rgbf> below(16, Rgbf(1));
  for (const int i : {5, 6, 9, 10}) below[static_cast<std::size_t>(i)] = {};
  const auto dark = portal(window(2, 3, 100), square_map(below));
  EXPECT_EQ(dark.sample_li({1, 1, 0}, {0.5, 0.5}).reason, NoLight::kBlack);
}

TEST(PortalLight, ATexelOf1e9AndItsNeighboursBothCount) {
  // The texel about +z from x, y > 0 is 1e9 brighter than the other three that the window shows.
  std::vector<Rgbf> texels(16, Rgbf(1));
  texels[10] = Rgbf(1e9);
  const auto light = portal({{{-1, -1, 4}, {-1, 1, 4}, {1, 1, 4}, {1, -1, 4}}}, square_map(texels));
  // The bright texel has a quarter of the window's form factor.
  const double a = 0.25, s = std::sqrt(1 + a * a);
  const double quarter = a / s * std::atan(a / s);
  const Mean got = illuminance(light, Vec3(0, 0, 0), 200000);
  EXPECT_NEAR(got.lx, quarter * (1e9 + 3), 5.5 * got.error);
  EXPECT_LE(got.error, 1e-3 * quarter * 1e9);
  // A receiver that sees only the other texels has a result as accurate as without the bright one.
  const Mean others = illuminance(light, Vec3(8, 8, 0), 20000);
  EXPECT_LE(others.lx, kPi);
  EXPECT_LE(others.error, 0.01 * others.lx);
}

TEST(PortalLight, CornersThatAreNearlyARectangleAreTakenAsTheirMean) {
  auto corners = window(2, 3, 1);
  corners[2].x += 0.001;
  const auto light = portal(corners);
  EXPECT_NEAR(light.portal_area_m2(), 6.0015, 1e-5);
}

TEST(PortalLight, CreateNamesTheInvalidParameter) {
  const auto error = [](PortalLightParams p) {
    return std::string(PortalLight::create(p).status().message());
  };
  const PortalLightParams good{.corners_m = window(2, 3, 1)};
  EXPECT_TRUE(PortalLight::create(good).ok());
  PortalLightParams p = good;
  p.corners_m[2].x += 0.01;
  EXPECT_THAT(error(p), ::testing::HasSubstr("(2.01, 3, 1)"));
  EXPECT_THAT(error(p), ::testing::HasSubstr("corners of a rectangle"));
  p = good;
  std::swap(p.corners_m[1], p.corners_m[2]);
  EXPECT_THAT(error(p), ::testing::HasSubstr("corners of a rectangle in order"));
  p = good;
  p.corners_m = window(0, 3, 1);
  EXPECT_THAT(error(p), ::testing::HasSubstr("corners of a rectangle"));
  p = good;
  p.corners_m[0].z = NAN;
  EXPECT_THAT(error(p), ::testing::HasSubstr("infinite.portal"));
  p = good;
  p.radiance_cd_m2 = {1, -2, 1};
  EXPECT_THAT(error(p), ::testing::HasSubstr("-2"));
  p = good;
  p.map = square_map({Rgbf(4)});
  p.radiance_cd_m2 = Rgb(1e308);
  EXPECT_THAT(error(p), ::testing::HasSubstr("brightest texel"));
  p = good;
  p.world_from_map = *Transform::scale({1, 2, 1});
  EXPECT_THAT(error(p), ::testing::HasSubstr("unequal scale"));
  p.radiance_cd_m2 = Rgb(1);
  p.rectified = true;
  EXPECT_EQ(error(p), "");
}

// As in pbrt-v4: a direction shows the texel of its direction in the map's own space.
TEST(PortalLight, AResampledMapMayBeStretched) {
  // 32 x 32 texels, each with its own radiance; so much of it that one direction shows one texel.
  std::vector<Rgbf> texels;
  for (int i = 0; i < 32 * 32; ++i) texels.emplace_back(static_cast<float>(i % 32));
  PortalLightParams p;
  p.corners_m = window(2, 3, 1);
  p.map = square_map(texels);
  p.rectified = true;
  const auto plain = PortalLight::create(p);
  p.world_from_map = *Transform::scale({1, 4, 2});
  const auto stretched = PortalLight::create(p);
  ASSERT_TRUE(plain.ok() && stretched.ok());
  const Vec3 inside{1, 1.5, 0};
  for (const Vec2 at : {Vec2{0.3, 0.2}, {1.7, 0.5}, {1.1, 2.8}, {0.1, 1.6}}) {
    const Vec3 own = Vec3{at.x, at.y, 1} - inside;
    const Vec3 seen{own.x, 4 * own.y, 2 * own.z};
    const Vec3 from = Vec3{1, 1.5, 1} - seen / seen.z;
    const double shown = stretched->le_escaped(from, normalized(seen)).g;
    EXPECT_NEAR(shown, plain->le_escaped(inside, normalized(own)).g, 1.5) << at.x << " " << at.y;
  }
}

TEST(PortalLight, NoSampleIsLostAtAGrazingAngle) {
  // 0.02 m by 1 m, seen from 100 m beside its short edge and 0.01 m below its plane.  So all its
  // directions are within 2e-4 of its axis y.  Rounding affects all three axes of the frame.
  const Vec3 x = normalized(Vec3{2, 3, 6}), y = normalized(Vec3{-6, -2, 3}), z = cross(x, y);
  const Vec3 corner = y * 100 - x * 0.01 + z * 0.01;
  const auto light =
      portal({{corner, corner + y * 1.0, corner + y * 1.0 + x * 0.02, corner + x * 0.02}});
  RandomU random(11);
  for (int i = 0; i < 10000; ++i) {
    const auto s = light.sample_li(Vec3{}, random.pair());
    ASSERT_EQ(s.reason, NoLight::kNone) << i;
    ASSERT_EQ(light.pdf_li(Vec3{}, s.wi), s.pdf);
  }
}

}  // namespace
}  // namespace lucerna

#include <gtest/gtest.h>

#include <vector>

#include "server/estimate/queries/irradiance.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using testing::build;

const Vec3f kPositionError{1e-6F, 1e-6F, 1e-6F};
const IrradianceSettings kDirect{.block_count = 16, .bounces = 0};

// Delta lights are computed light by light.  The result equals that of point by point.
TEST(DeltaIrradiance, IsTheSameByEveryPathOfTheCode) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9), testing::floor(1, 2)};
  d.lights = {testing::point_light({3, 0, 4}, 100),
              testing::point_light({0, 0, 5}, 70),
              {DistantLightParams{.to_light = {1, 2, 3}, .illuminance_lx = Rgb(40)}, {}},
              {SpotLightParams{.position_m = {-2, 1, 3},
                               .axis = {0, 0, -1},
                               .intensity_cd = Rgb(30),
                               .cone_half_angle_rad = 0.8},
               {}}};
  const auto scene = build(std::move(d));
  std::vector<IrradiancePoint> points;
  for (int i = 0; i < 150; ++i)
    points.push_back(
        {{i % 13 - 6.0, i % 11 - 5.0, 0}, kPositionError, {0, 0, i % 5 == 0 ? -1.0F : 1.0F}});
  IrradianceSettings settings = kDirect;
  settings.per_light = true;
  const IrradianceResult by_light = estimate_irradiance(*scene, points, settings, {});
  const std::vector<double> wavelengths{555};
  settings.wavelengths_nm = wavelengths;  // these are computed point by point
  const IrradianceResult by_point = estimate_irradiance(*scene, points, settings, {});
  settings.wavelengths_nm = {};
  settings.target = TargetError{.relative = 0.01};
  const IrradianceResult of_target = estimate_irradiance(*scene, points, settings, {});
  EXPECT_GT(by_light.work.shadow_rays, points.size());
  // Points are timed only with a target.
  for (const PointCost& cost : of_target.costs) EXPECT_GT(cost.time_s, 0);
  for (const PointCost& cost : by_light.costs) EXPECT_EQ(cost.time_s, 0);
  for (const IrradianceResult& other : {by_point, of_target}) {
    EXPECT_EQ(by_light.work.shadow_rays, other.work.shadow_rays);
    for (std::size_t p = 0; p < points.size(); ++p) {
      EXPECT_TRUE(other.points[p].exact);
      EXPECT_EQ(by_light.points[p].irradiance_lx, other.points[p].irradiance_lx) << p;
      EXPECT_EQ(by_light.points[p].illuminance_lx.upper, other.points[p].illuminance_lx.upper);
      EXPECT_EQ(by_light.costs[p].rays, other.costs[p].rays) << p;
      EXPECT_EQ(other.costs[p].samples, 0U);
      for (std::size_t l = p * 4; l < p * 4 + 4; ++l)
        EXPECT_EQ(by_light.per_light[l].irradiance_lx, other.per_light[l].irradiance_lx) << l;
    }
  }
}

TEST(DeltaIrradiance, OfAPointLightIsTheSameByEveryPathAtAnyDistance) {
  for (const double candela : {0.0, 1e-30, 18.0, 1e30}) {
    SceneDescription d = testing::description();
    d.lights = {testing::point_light({1, -2, 0.5}, candela)};
    const auto scene = build(std::move(d));
    const Vec3 light = Vec3{1, -2, 0.5} - scene->origin();
    std::vector<IrradiancePoint> points{{light, {}, {0, 0, 1}}};
    for (double size = 1e-200; size < 1e200; size *= 1e5)
      for (const Vec3& way : {Vec3{1, 2, -3}, {-1, 0, 0}, {0, 0.3, 1}})
        for (const float up : {-1.0F, 1.0F})
          points.push_back({light + way * size, kPositionError, {0, 0, up}});
    IrradianceSettings settings = kDirect;
    const IrradianceResult by_light = estimate_irradiance(*scene, points, settings, {});
    const std::vector<double> wavelengths{555};
    settings.wavelengths_nm = wavelengths;  // these are computed point by point
    const IrradianceResult by_point = estimate_irradiance(*scene, points, settings, {});
    std::size_t lit = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      EXPECT_EQ(by_light.points[p].irradiance_lx, by_point.points[p].irradiance_lx) << p;
      EXPECT_TRUE(by_light.points[p].exact);
      if (!by_light.points[p].irradiance_lx.is_black()) ++lit;
    }
    EXPECT_EQ(by_light.work.shadow_rays, 0U);
    EXPECT_EQ(lit > 0, candela > 0);
  }
}

}  // namespace
}  // namespace lucerna

// Row 35: scenes without geometry, without lights, or without both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/estimate/render.h"
#include "server/queries/receiver_irradiance.h"
#include "tests/extremes_sweep.h"
#include "tests/server/extremes/file_scenes.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

/// Half the diagonal of a box around points on a diagonal.  The box starts empty.  [Pharr23, 3.7]
float textbook_radius(std::initializer_list<float> points) {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  for (const float p : points) low = std::min(low, p), high = std::max(high, p);
  const float side = high - low;
  return std::sqrt(3 * side * side) / 2;
}

SceneDescription with_light(LightDescription light) {
  SceneDescription d = description();
  d.lights = {std::move(light)};
  return d;
}

LightDescription sky(double radiance) {
  return {UniformInfiniteLightParams{Rgb(radiance)}, {"test.pbrt", 5, 1}};
}

IrradianceEstimate irradiance(const Scene& scene, const Vec3& position, const Vec3f& normal) {
  IrradiancePoint point;
  point.position = position;
  point.normal = Vec3(normal);
  IrradianceSettings settings;
  settings.samples_per_block = 1024;
  settings.block_count = 16;
  return estimate_irradiance(scene, {&point, 1}, settings, {}).points.at(0);
}

TileResult tile(const Scene& scene) {
  TileSettings settings;
  settings.rect = {0, 0, scene.camera().width(), scene.camera().height()};
  settings.samples_per_block = 16;
  return render_tile(scene, settings, {});
}

TEST(EmptyExtremes, Radius) {
  Sweep sweep(35, "an empty scene; scenes with one light, with a floor, with two separate lights",
              "1e-30 ... 1e29 m", "radius");
  sweep.compare(build(description())->sphere().radius_m, 0, "nothing");
  sweep.compare_textbook(textbook_radius({}), 0);
  sweep.compare(build(with_light(sky(1)))->sphere().radius_m, 0, "a sky");
  for (int exponent = -30; exponent <= 29; ++exponent) {
    const double x = std::pow(10.0, exponent);
    sweep.compare(build(with_light(point_light({x, x, x}, 1)))->sphere().radius_m, 0, "one light");
    SceneDescription d = description();
    d.lights = {point_light({-x, -x, -x}, 1), point_light({x, x, x}, 1)};
    sweep.compare(build(d)->sphere().radius_m, std::sqrt(3.0) * x, "two lights");
    const auto end = static_cast<float>(x);
    sweep.compare_textbook(textbook_radius({-end, end}), std::sqrt(3.0) * x);
    SceneDescription ground = description();
    ground.shapes = {floor(x)};
    sweep.compare(build(ground)->sphere().radius_m, std::sqrt(2.0) * x, "a floor");
  }
  sweep.expect_within(1e-6);
}

TEST(EmptyExtremes, Power) {
  Sweep sweep(35, "lights at infinity without geometry", "1e-30 ... 1e30 cd/m2", "flux");
  for (int exponent = -30; exponent <= 30; exponent += 5) {
    const Rgb level(std::pow(10.0, exponent));
    const LightDescription kLights[] = {
        {UniformInfiniteLightParams{level}, {}},
        {DistantLightParams{{0, 0, 1}, level}, {}},
        {SunLightParams{{0, 0, 1}, 0.01, level}, {}},
    };
    for (const LightDescription& light : kLights) {
      sweep.compare(flux_lm(*build(with_light(light))), 0, "no geometry");
      const float radius = textbook_radius({});
      sweep.compare_textbook(
          std::numbers::pi_v<float> * radius * radius * static_cast<float>(level.g), 0);
    }
  }
  sweep.expect_within(0);
}

TEST(EmptyExtremes, IrradianceWithoutLights) {
  Sweep sweep(35, "an empty scene, or geometry without lights", "receivers at 0 ... 1e15 m",
              "irradiance");
  SceneDescription ground = description();
  ground.shapes = {floor(5)};
  for (const auto& scene : {build(description()), build(ground)})
    for (const double x : {0.0, 1e-30, 1.0, 1e15}) {
      const IrradianceEstimate e = irradiance(*scene, {x, x, x + 1}, {0, 0, 1});
      sweep.compare(e.irradiance_lx.g, 0, std::to_string(x));
      EXPECT_TRUE(e.exact);
      EXPECT_EQ(e.illuminance_error_lx, 0);
      EXPECT_EQ(e.zero_bound_lx, 0);
      // The mean over the lights, of which the scene has none.
      sweep.compare_textbook(0.0F / static_cast<float>(scene->lights().size()), 0);
    }
  sweep.expect_within(0);
}

TEST(EmptyExtremes, IrradianceWithoutGeometry) {
  Sweep sweep(35, "a point light or a distant light, without geometry",
              "distances of 1e-9 ... 1e9 m", "irradiance");
  for (int exponent = -9; exponent <= 9; ++exponent) {
    const double d = std::ldexp(1.0, 3 * exponent);
    const auto point = build(with_light(point_light({0, 0, d}, 2)));
    const IrradianceEstimate e = irradiance(*point, -point->origin(), {0, 0, 1});
    EXPECT_TRUE(e.exact);
    sweep.compare(e.irradiance_lx.g, 2 / d / d, std::to_string(d));
    const auto f = static_cast<float>(d);
    sweep.compare_textbook(2 / (f * f), 2 / d / d);
    const auto distant =
        build(with_light({DistantLightParams{{0, 0, 1}, Rgb(d)}, {"test.pbrt", 5, 1}}));
    sweep.compare(irradiance(*distant, {1, 2, 3}, {0, 0, 1}).irradiance_lx.g, d, "distant");
  }
  sweep.expect_within(1e-6);
}

TEST(EmptyExtremes, Tiles) {
  Sweep sweep(35, "an empty scene, geometry without lights, only a sky",
              "a sky of 0, 1e-30 ... 1e30 cd/m2", "every pixel");
  SceneDescription ground = description();
  ground.shapes = {floor(5, 1)};
  for (const auto& scene : {build(description()), build(ground)})
    for (const BlockStatistics& s : tile(*scene).channels) {
      sweep.compare(s.sum, 0, "no lights");
      EXPECT_EQ(s.deviation, 0);
    }
  for (int exponent = -30; exponent <= 30; exponent += 10) {
    const double level = std::pow(10.0, exponent);
    for (const BlockStatistics& s : tile(*build(with_light(sky(level)))).channels)
      sweep.compare(s.sum, level, std::to_string(exponent));
  }
  // A light is chosen from an empty set.
  sweep.compare_textbook(0.0F / 0.0F * std::numeric_limits<float>::infinity(), 0);
  sweep.expect_within(1e-7);
}

}  // namespace
}  // namespace lucerna::testing

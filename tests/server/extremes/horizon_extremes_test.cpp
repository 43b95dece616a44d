// Row 38: lights with only a small part above the receiver's horizon.  Most answers of a few
// samples are 0.  They must not be called exact.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "server/queries/receiver_irradiance.h"
#include "tests/extremes_sweep.h"
#include "tests/lights/closed_forms.h"
#include "tests/server/scene/scenes.h"

namespace lucerna::testing {
namespace {

constexpr int kSeedsOfLow = 20;

/// A light 1 m away whose upper edge is `above` the horizon [m], and its illuminance at the origin.
struct Low {
  const char* name;
  SceneDescription scene;
  double lx;
};

/// The upright square from `above` - 1 to `above`.
std::array<Vec3, 4> upright(double above) {
  return {Vec3{1, -0.5, above - 1}, Vec3{1, -0.5, above}, Vec3{1, 0.5, above - 1},
          Vec3{1, 0.5, above}};
}

double of_square(double above) {
  const auto s = upright(above);
  return polygon_irradiance({s[0], s[1], s[3], s[2]}, {}, {0, 0, 1});
}

Low painted(double above) {
  SceneDescription d = description();
  const auto s = upright(above);
  d.shapes = {emissive(patch(s[0], s[1], s[2], s[3]), 1, true)};
  d.shapes[0].emission->picture =
      Picture{*Image::create(2, 2, std::vector<Rgbf>(4, Rgbf(1))), ImageFilter::kBilinear, ""};
  return {"painted square", std::move(d), of_square(above)};
}

/// One corner is 1e-9 m off the plane of the others, so there is no closed form.
Low folded(double above) {
  SceneDescription d = description();
  const auto s = upright(above);
  d.shapes = {emissive(patch(s[0], s[1], s[2], s[3] + Vec3{1e-9, 0, 0}), 1, true)};
  return {"bent patch", std::move(d), of_square(above)};
}

Low portal(double above) {
  SceneDescription d = description();
  PortalLightParams params;
  params.map = *SphereMap::create(*Image::create(2, 2, std::vector<Rgbf>(4, Rgbf(1))),
                                  SphereMapping::kEqualArea, ImageFilter::kNearest);
  const auto s = upright(above);
  params.corners_m = {s[0], s[1], s[3], s[2]};
  const Vec3 to_sky = cross(s[2] - s[0], s[1] - s[0]);
  if (to_sky.x < 0) std::swap(params.corners_m[1], params.corners_m[3]);
  d.lights = {{params, {}}};
  return {"portal", std::move(d), of_square(above)};
}

/// A long cylinder across the view.  The strip above the horizon is nearly flat.
Low cylinder(double above) {
  constexpr double kRadius = 0.5, kHalf = 1e4;
  SceneDescription d = description();
  d.shapes = {emissive(
      {CylinderParams{.radius_m = kRadius,
                      .z_min_m = -kHalf,
                      .z_max_m = kHalf,
                      .world_from_object = Transform::translate({2, 0, above - kRadius}) *
                                           *Transform::rotate(1.5707963267948966, {1, 0, 0})}},
      1, true)};
  // An endless cylinder fills the directions between the horizon and its tangent.
  const double centre = std::atan2(above - kRadius, 2.0);
  const double top = centre + std::asin(kRadius / std::hypot(2.0, above - kRadius));
  return {"cylinder", std::move(d), std::numbers::pi / 2 * (1 - std::cos(top))};
}

using Make = Low (*)(double);

IrradianceEstimate answer(const Scene& scene, std::uint64_t seed) {
  const IrradiancePoint point{-scene.origin(), {}, {0, 0, 1}};
  return estimate_irradiance(scene, std::span(&point, 1),
                             {.seed = seed, .samples_per_block = 4, .block_count = 4, .bounces = 0},
                             {})
      .points[0];
}

TEST(HorizonExtremes, LowLights) {
  Sweep sweep(38, "painted square, bent patch, cylinder and portal, partly above the horizon",
              "1e-9 ... 0.1 of 1 m above it; 16 samples",
              "0 that is called exact, or too low a bound");
  std::int64_t wrong = 0, cases = 0, zeros = 0;
  for (const Make make : {painted, folded, portal, cylinder})
    for (int exponent = -9; exponent <= -1; ++exponent) {
      Low low = make(std::pow(10.0, exponent));
      const auto scene = build(std::move(low.scene));
      for (int seed = 0; seed < kSeedsOfLow; ++seed, ++cases) {
        const IrradianceEstimate e = answer(*scene, static_cast<std::uint64_t>(seed));
        if (!e.irradiance_lx.is_black()) continue;  // IrradianceCoverage tests these
        ++zeros;
        if (!e.exact && e.illuminance_lx.upper >= low.lx * (1 - 1e-5)) continue;
        if (++wrong < 10)
          ADD_FAILURE() << low.name << " 1e" << exponent << " m: at most " << e.illuminance_lx.upper
                        << ", right is " << low.lx;
      }
    }
  EXPECT_GT(zeros, cases / 4);
  sweep.expect_none(wrong, cases, 0);
}

TEST(HorizonExtremes, LowLightsBesideOthers) {
  Sweep sweep(38, "a low painted square 1e6 times as bright as a lamp overhead",
              "1e-9 ... 1e-3 of 1 m above the horizon; 16 samples", "too low an upper end");
  std::int64_t wrong = 0, cases = 0;
  for (int exponent = -9; exponent <= -3; ++exponent) {
    Low low = painted(std::pow(10.0, exponent));
    low.scene.shapes[0].emission->radiance_cd_m2 = Rgb(1e6);
    // A cylinder has no closed form, so it is sampled.
    low.scene.shapes.push_back(emissive(
        {CylinderParams{.radius_m = 0.3, .world_from_object = Transform::translate({0, 0, 3})}}, 1,
        true));
    const auto scene = build(std::move(low.scene));
    for (int seed = 0; seed < kSeedsOfLow; ++seed, ++cases) {
      const IrradianceEstimate e = answer(*scene, static_cast<std::uint64_t>(seed));
      if (e.illuminance_lx.upper >= 1e6 * low.lx * (1 - 1e-5)) continue;
      if (++wrong < 10)
        ADD_FAILURE() << "1e" << exponent << " m: at most " << e.illuminance_lx.upper
                      << ", right is more than " << 1e6 * low.lx;
    }
  }
  sweep.expect_none(wrong, cases, 0);
}

TEST(HorizonExtremes, LightsBelow) {
  Sweep sweep(38, "the same, all below the horizon", "1e-9 ... 0.1 m below it; 16 samples",
              "upper bound above 0");
  std::int64_t wrong = 0, cases = 0;
  for (const Make make : {painted, folded, portal, cylinder})
    for (int exponent = -9; exponent <= -1; ++exponent, ++cases) {
      Low low = make(-std::pow(10.0, exponent));
      const IrradianceEstimate e = answer(*build(std::move(low.scene)), 0);
      if (e.illuminance_lx.upper == 0) continue;
      ++wrong;
      ADD_FAILURE() << low.name << " 1e" << exponent << " m: at most " << e.illuminance_lx.upper;
    }
  sweep.expect_none(wrong, cases, 0);
}

/// The upper half of the sky is lit.  With `spread`, the filter carries some light below the
/// horizon, too little for samples to find.
std::shared_ptr<const Scene> half_sky(bool spread) {
  constexpr int kWidth = 8, kHeight = 1000;
  std::vector<Rgbf> texels(kWidth * kHeight);
  for (std::size_t i = 0; i < texels.size() / 2; ++i) texels[i] = Rgbf(1);
  ImageInfiniteLightParams sky;
  sky.map =
      *SphereMap::create(*Image::create(kWidth, kHeight, texels), SphereMapping::kLatitudeLongitude,
                         spread ? ImageFilter::kBilinear : ImageFilter::kNearest);
  sky.world_from_map = *Transform::rotate(std::numbers::pi / 2, {1, 0, 0});  // +y up to +z
  SceneDescription d = description();
  d.lights = {{sky, {}}};
  return build(std::move(d));
}

TEST(HorizonExtremes, HalfSkiesAtReceiversThatFaceDown) {
  Sweep sweep(38, "a sky whose lower half is black, seen by receivers that face down",
              "nearest and bilinear filter; 16 samples", "answer");
  for (const bool spread : {false, true}) {
    const auto scene = half_sky(spread);
    const IrradiancePoint point{-scene->origin(), {}, {0, 0, -1}};
    const IrradianceEstimate e =
        estimate_irradiance(*scene, std::span(&point, 1),
                            {.samples_per_block = 4, .block_count = 4, .bounces = 0}, {})
            .points[0];
    const bool right = spread ? e.illuminance_lx.upper > 0 : e.illuminance_lx.upper == 0;
    sweep.answer(right ? "0 without filter, more than 0 with it" : "wrong");
  }
  sweep.expect_answers("0 without filter, more than 0 with it");
}

}  // namespace
}  // namespace lucerna::testing

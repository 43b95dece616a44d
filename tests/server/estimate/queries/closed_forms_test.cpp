// Irradiance of whole scenes against closed forms (tests/lights/closed_forms.h).  Light samples and
// surface samples are combined, with every area sampling method.
#include "tests/lights/closed_forms.h"

#include <gtest/gtest.h>

#include "server/estimate/queries/irradiance.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using std::numbers::pi;
using testing::build;
using testing::polygon_irradiance;

constexpr AreaSampling kAreaSamplings[] = {
    AreaSampling::kAutomatic,     AreaSampling::kSquareRoot,      AreaSampling::kKraemer,
    AreaSampling::kParallelogram, AreaSampling::kRejection,       AreaSampling::kLowDistortion,
    AreaSampling::kSolidAngle,    AreaSampling::kCosineSolidAngle};

/// Expects direct light at `receiver` to be `expected` [lx] for each method, within 7 standard
/// errors of 64 blocks.  They are exceeded by chance once in 5e8 (Student's t).  The standard
/// errors must be below 2%.
void expect_irradiance(const Scene& scene, const Vec3<double>& receiver, const Vec3<double>& n,
                       double expected) {
  const IrradiancePoint point{receiver - scene.origin(), {1e-6F, 1e-6F, 1e-6F}, n};
  IrradianceSettings settings{
      .seed = 11, .samples_per_block = 256, .block_count = 64, .bounces = 0};
  for (const AreaSampling way : kAreaSamplings) {
    settings.methods.area_sampling = way;
    const auto e = estimate_irradiance(scene, std::span(&point, 1), settings, {}).points[0];
    EXPECT_NEAR(e.irradiance_lx.g, expected, 7 * e.standard_error_lx.g + 1e-6 * expected)
        << int(way);
    EXPECT_LT(e.standard_error_lx.g, 0.02 * expected) << int(way);
  }
}

TEST(IrradianceInClosedForm, OfATriangleWholeAndCutByTheHorizon) {
  const std::vector<Vec3<double>> corners{{0, 0, 2}, {1, 3, 2.5}, {2, -1, 2.25}};
  SceneDescription d = testing::description();
  d.shapes = {testing::emissive(testing::shape(TriangleMeshData{corners, {}, {0, 1, 2}}), 5, true)};
  const auto scene = build(std::move(d));
  const Vec3<double> r{0.5, 0.25, 0};
  for (const Vec3<double>& direction : {Vec3<double>{0, 0.25, 1}, {1, -0.5, 0}, {-1, 0, 0.5}}) {
    const Vec3<double> n = normalized(direction);
    expect_irradiance(*scene, r, n, 5 * polygon_irradiance(corners, r, n));
  }
}

TEST(IrradianceInClosedForm, OfARectangleNearAndFar) {
  SceneDescription d = testing::description();
  d.shapes = {
      testing::emissive(testing::patch({-1, -0.5, 2}, {-1, 0.5, 2}, {1, -0.5, 2}, {1, 0.5, 2}), 5)};
  const auto scene = build(std::move(d));
  const std::vector<Vec3<double>> corners{{-1, -0.5, 2}, {1, -0.5, 2}, {1, 0.5, 2}, {-1, 0.5, 2}};
  const Vec3<double> n = normalized(Vec3<double>{0.5, 0, 1});
  for (const Vec3<double>& r : {Vec3<double>{0.5, 0.25, 0}, {0.25, 0.25, 1.75}, {4, -3, -10}})
    expect_irradiance(*scene, r, n, 5 * polygon_irradiance(corners, r, n));
}

TEST(IrradianceInClosedForm, OfASphereWholeCutByTheHorizonAndFromWithin) {
  const auto scene = [](bool inwards) {
    SceneDescription d = testing::description();
    SphereParams sphere;
    sphere.radius_m = 2;
    sphere.reverse_orientation = inwards;
    sphere.world_from_object = Transform::translate({0, 0, 4});
    d.shapes = {testing::emissive(testing::shape(sphere), 5)};
    return build(std::move(d));
  };
  const auto outwards = scene(false);
  for (const Vec3<double>& direction : {Vec3<double>{0.8, 0, 0.6}, {1, 0, 0}, {1, 0.25, 0.125}}) {
    const Vec3<double> n = normalized(direction);
    expect_irradiance(*outwards, {0, 0, 0}, n,
                      5 * testing::sphere_irradiance({0, 0, 4}, 2, {0, 0, 0}, n));
  }
  expect_irradiance(*scene(true), {0.5, 0.25, 3}, {0.6, 0, -0.8}, 5 * pi);
}

TEST(IrradianceInClosedForm, OfADiskCoaxialAndOffset) {
  SceneDescription d = testing::description();
  d.shapes = {testing::emissive(
      testing::shape(DiskParams{.height_m = 3, .radius_m = 1.5, .reverse_orientation = true}), 5)};
  const auto scene = build(std::move(d));
  for (const auto& [height, offset] :
       {std::pair{3.0, 0.0}, {0.25, 0.5}, {0.5, 1.5}, {0.5, 3.0}, {2.0, 6.0}})
    expect_irradiance(*scene, {offset, 0, 3 - height}, {0, 0, 1},
                      5 * testing::disk_irradiance(1.5, height, offset));
}

TEST(IrradianceInClosedForm, OfASkyOverAPlane) {
  // A black square of 18 m by 18 m, 0.5 m below the receiver, hides part of a sky of radiance 5.
  // The whole sky would give 5 pi for any normal.
  SceneDescription d = testing::description(0);
  d.shapes = {testing::floor(9)};
  d.lights = {{UniformInfiniteLightParams{Rgb<double>(5)}, {}}};
  const auto scene = build(std::move(d));
  const std::vector<Vec3<double>> floor{{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}};
  const Vec3<double> r{2, 1, 0.5};
  for (const Vec3<double>& direction : {Vec3<double>{0, 0, 1}, {1, 0, 1}, {1, 0.5, 0}}) {
    const Vec3<double> n = normalized(direction);
    expect_irradiance(*scene, r, n, 5 * (pi - polygon_irradiance(floor, r, n)));
  }
  // The limit of a large square: 5 pi (1 + cos t) / 2 at an angle t to the vertical.
  const Vec3<double> n = normalized(Vec3<double>{1, 0, 1});
  EXPECT_NEAR(pi - polygon_irradiance(floor, {0, 0, 1e-6}, n), pi * (1 + n.z) / 2, 1e-6);
}

}  // namespace
}  // namespace lucerna

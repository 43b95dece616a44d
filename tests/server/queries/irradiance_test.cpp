#include <gtest/gtest.h>

#include "server/queries/receiver_irradiance.h"
#include "tests/server/scene/scenes.h"

namespace lucerna {
namespace {

using std::numbers::pi;
using testing::build;

constexpr float kError = 1e-6f;

IrradiancePoint at(float x, float y, float z, const Vec3& n = {0, 0, 1}) {
  return {{x, y, z}, {kError, kError, kError}, n};
}

IrradianceSettings direct(std::uint32_t samples = 16, std::uint32_t blocks = 16) {
  return {.seed = 9, .samples_per_block = samples, .block_count = blocks, .bounces = 0};
}

IrradianceEstimate one(const Scene& scene, const IrradiancePoint& point,
                       const IrradianceSettings& settings = direct()) {
  return estimate_irradiance(scene, std::span(&point, 1), settings, {}).points[0];
}

// The surface of a lamp that a sky replaces stays, and is dark.
TEST(Irradiance, OfASkyInPlaceOfALampIsShadowedByTheLamp) {
  SceneDescription d = testing::description();
  d.shapes = {testing::emissive(testing::floor(1, 1), 5)};
  LightEdits edits;
  edits.added[1] = {.light = {.params = UniformInfiniteLightParams{Rgb(1)}}, .content = "sky"};
  const auto edited = Scene::revise(build(d), std::move(edits));
  ASSERT_TRUE(edited.ok()) << edited.status();
  const IrradianceEstimate e = one(**edited, at(0, 0, 0.5f));
  // The lamp hides a square of half side 1 at a height of 0.5.
  const double hidden = 4 * (2 / std::sqrt(5.0)) * std::atan(2 / std::sqrt(5.0));
  EXPECT_NEAR(e.irradiance_lx.g, pi - hidden, 0.05);
  EXPECT_FALSE(e.exact);
}

/// The same light without a closed form.
IrradianceSettings sampled(std::uint32_t samples = 16, std::uint32_t blocks = 16) {
  IrradianceSettings settings = direct(samples, blocks);
  settings.methods.closed_forms = ClosedForms::kOff;
  return settings;
}

TEST(Irradiance, OutdoorsOfAPortalMayMissTheSky) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9)};
  PortalLightParams portal;
  portal.radiance_cd_m2 = Rgb(5);
  portal.corners_m = {{{1, -1, 0}, {1, -1, 2}, {1, 1, 2}, {1, 1, 0}}};
  d.lights.emplace_back().params = portal;
  using Kind = MissedLight::Kind;
  const auto open = build(d);
  EXPECT_EQ(one(*open, at(3, 0, 0)).missed.kind, Kind::kOutdoors);
  EXPECT_EQ(one(*open, at(1, 3, 1, {1, 0, 0})).missed.kind, Kind::kOutdoors) << "in its plane";
  EXPECT_EQ(one(*open, at(-3, 0, 0)).missed.kind, Kind::kNone);
  // In another room on that side of the portal.
  d.shapes.push_back({.geometry = SphereParams{
                          .radius_m = 1, .world_from_object = Transform::translate({5, 0, 3})}});
  EXPECT_EQ(one(*build(d), at(5, 0, 3)).missed.kind, Kind::kNone);
  d.shapes.clear();
  EXPECT_EQ(one(*build(d), at(3, 0, 0)).missed.kind, Kind::kOutdoors) << "without surfaces";
}

TEST(Irradiance, UnderAUniformSkyIsPiTimesItsRadiance) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9)};
  d.lights = {{UniformInfiniteLightParams{Rgb(2)}, {}}};
  const auto scene = build(std::move(d));
  const IrradianceEstimate e = one(*scene, at(0, 0, 0), sampled(64));
  EXPECT_NEAR(e.irradiance_lx.g, 2 * pi, 5 * e.illuminance_error_lx);
  EXPECT_LT(e.illuminance_error_lx, 0.01 * 2 * pi);
  EXPECT_FALSE(e.exact);
  const IrradianceEstimate known = one(*scene, at(0, 0, 0));
  EXPECT_NEAR(known.irradiance_lx.g, 2 * pi, 1e-12);
  EXPECT_EQ(known.illuminance_error_lx, 0);
  EXPECT_TRUE(known.exact);
}

// A board hides the lamp from one point of the floor and not from another.
TEST(Irradiance, IsExactOnlyWithoutObstacles) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9), testing::patch({1, -9, 1}, {9, -9, 1}, {1, 9, 1}, {9, 9, 1}),
              testing::emissive(testing::patch({-1, -1, 2}, {-1, 1, 2}, {1, -1, 2}, {1, 1, 2}), 5)};
  const auto scene = build(std::move(d));
  const IrradianceEstimate open = one(*scene, at(0, 0, 0)), shaded = one(*scene, at(1.5F, 0, 0));
  EXPECT_TRUE(open.exact);
  EXPECT_FALSE(shaded.exact);
  const IrradianceEstimate estimate = one(*scene, at(0, 0, 0), sampled(256));
  EXPECT_NEAR(open.irradiance_lx.g, estimate.irradiance_lx.g, 5 * estimate.illuminance_error_lx);
  // Reflected light is sampled nevertheless.
  IrradianceSettings all = direct();
  all.bounces = 1;
  EXPECT_FALSE(one(*scene, at(0, 0, 0), all).exact);
}

// Shafts take as long as a few samples.  With fewer samples they are not used, unless the answer
// would be exact.
TEST(Irradiance, ClosedFormsAreUsedFromAFewSamplesOn) {
  SceneDescription d = testing::description(0.6);
  d.shapes = {testing::floor(9),
              testing::emissive(testing::patch({-1, -1, 2}, {-1, 1, 2}, {1, -1, 2}, {1, 1, 2}), 5)};
  const auto scene = build(std::move(d));
  const auto estimate = [&](std::uint32_t samples, std::uint32_t bounces,
                            ClosedForms closed_forms) {
    IrradianceSettings settings = direct(samples, 1);
    settings.bounces = bounces;
    settings.methods.closed_forms = closed_forms;
    return one(*scene, at(0.3F, 0.2F, 0), settings).irradiance_lx.g;
  };
  EXPECT_EQ(estimate(3, 2, ClosedForms::kAutomatic), estimate(3, 2, ClosedForms::kOff));
  EXPECT_NE(estimate(3, 2, ClosedForms::kEmptyShafts), estimate(3, 2, ClosedForms::kOff));
  EXPECT_EQ(estimate(4, 2, ClosedForms::kAutomatic), estimate(4, 2, ClosedForms::kEmptyShafts));
  EXPECT_NE(estimate(4, 2, ClosedForms::kEmptyShafts), estimate(4, 2, ClosedForms::kOff));
  EXPECT_EQ(estimate(1, 0, ClosedForms::kAutomatic), estimate(1, 0, ClosedForms::kEmptyShafts));
}

// With nine lamps or more, each sample chooses among them.
SceneDescription lamps(int n) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9)};
  for (int i = 0; i < n; ++i)
    d.lights.push_back(testing::point_light({double(i), 0, 4}, 10.0 * (i + 1)));
  return d;
}

double of_lamps(int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += 10.0 * (i + 1) * 4 / std::pow(double(i) * i + 16, 1.5);
  return sum;
}

TEST(Irradiance, OfManyDeltaLightsIsExactWhereSamplesCostMore) {
  const auto scene = build(lamps(64));
  // A sample of drawn lights costs as much as 12 of them.
  const IrradianceEstimate e = one(*scene, at(0, 0, 0), direct(1, 6));
  EXPECT_TRUE(e.exact);
  EXPECT_NEAR(e.irradiance_lx.g, of_lamps(64), 1e-9 * of_lamps(64));
  EXPECT_FALSE(one(*scene, at(0, 0, 0), direct(1, 5)).exact);
  IrradianceSettings settings = direct(1, 5);
  settings.per_light = true;
  EXPECT_TRUE(one(*scene, at(0, 0, 0), settings).exact);
}

/// The number of samples that a target needs at a point, with 16 blocks.  The answer equals
/// that of a query for this number.
std::uint64_t samples_for(const TargetError& target, const Scene& scene,
                          const IrradiancePoint& point) {
  IrradianceSettings settings = direct(1, 16);
  settings.target = target;
  const IrradianceResult r = estimate_irradiance(scene, std::span(&point, 1), settings, {});
  const std::uint64_t samples = r.costs[0].samples;
  EXPECT_LE(samples, target.max_samples);
  const IrradianceEstimate e =
      one(scene, point, direct(static_cast<std::uint32_t>(samples / 16), 16));
  EXPECT_EQ(r.points[0].irradiance_lx, e.irradiance_lx) << target.relative;
  EXPECT_EQ(r.points[0].illuminance_error_lx, e.illuminance_error_lx) << target.relative;
  return samples;
}

// Many lamps beside a sky and a panel.  With a target, the same lights are settled and drawn as in
// a query for the same sample count.
TEST(Irradiance, OfATargetHasTheBitsOfAQueryForItsCount) {
  SceneDescription d = lamps(3000);
  for (LightDescription& l : d.lights) std::get<PointLightParams>(l.params).position_m.x *= 0.01;
  d.lights.push_back({UniformInfiniteLightParams{Rgb(1, 2, 3)}, {}});
  d.shapes.push_back(
      testing::emissive({DiskParams{.height_m = 5, .reverse_orientation = true}}, 500));
  d.shapes.push_back(testing::patch({1, -1, 1}, {2, -1, 1}, {1, 1, 1}, {2, 1, 1}));
  const auto scene = build(std::move(d));
  for (const double relative : {0.3, 0.1, 0.01, 0.001})
    EXPECT_GT(samples_for({.relative = relative}, *scene, at(0.5F, 0, 0)), 0u);
}

// 3008 lamps are settled from 188 samples on.  While they are drawn they need more than that.  Once
// they are settled, the sky alone needs 64.
TEST(Irradiance, OfATargetTakesEnoughSamplesToSettleDeltaLights) {
  SceneDescription d = lamps(2256);
  for (LightDescription& l : d.lights) std::get<PointLightParams>(l.params).position_m.x *= 0.01;
  d.lights.push_back({UniformInfiniteLightParams{Rgb(1)}, {}});
  d.shapes.push_back(testing::patch({1, -1, 1}, {2, -1, 1}, {1, 1, 1}, {2, 1, 1}));
  const auto scene = build(std::move(d));
  EXPECT_EQ(samples_for({.relative = 0.05}, *scene, at(0.5F, 0, 0)), 192u);
  // With fewer samples the lamps are drawn.
  EXPECT_EQ(samples_for({.relative = 0.001, .max_samples = 160}, *scene, at(0.5F, 0, 0)), 160u);
}

// 512 lamps are settled from 43 samples on; the first pilot has more.
TEST(Irradiance, OfATargetTakesAtMostTheLargestSampleCount) {
  SceneDescription d = lamps(512);
  d.lights.push_back({UniformInfiniteLightParams{Rgb(1)}, {}});
  d.shapes.push_back(testing::patch({1, -1, 1}, {2, -1, 1}, {1, 1, 1}, {2, 1, 1}));
  const auto scene = build(std::move(d));
  EXPECT_EQ(samples_for({.relative = 0.1, .max_samples = 16}, *scene, at(0, 0, 0)), 16u);
}

TEST(Irradiance, IsTheSumOfItsShares) {
  SceneDescription d = lamps(2);
  d.lights.push_back({UniformInfiniteLightParams{Rgb(1, 2, 3)}, {}});
  d.shapes.push_back(
      testing::emissive({DiskParams{.height_m = 5, .reverse_orientation = true}}, 5));
  const auto scene = build(std::move(d));
  IrradianceSettings settings = direct();
  settings.per_light = true;
  const std::vector<IrradiancePoint> points{at(0, 0, 0), at(1, 2, 0)};
  const IrradianceResult r = estimate_irradiance(*scene, points, settings, {});
  ASSERT_EQ(r.per_light.size(), 8u);
  for (std::size_t p = 0; p < 2; ++p) {
    Rgb sum;
    for (std::size_t l = 0; l < 4; ++l) sum += r.per_light[4 * p + l].irradiance_lx;
    EXPECT_NEAR(sum.g / r.points[p].irradiance_lx.g, 1, 1e-6);
    EXPECT_NEAR(sum.b / r.points[p].irradiance_lx.b, 1, 1e-6);
    EXPECT_TRUE(r.per_light[4 * p].exact);
    EXPECT_FALSE(r.per_light[4 * p + 2].exact);
  }
}

TEST(Irradiance, OfOneLightHasTheIntervalOfItsShare) {
  // Half of the lamp is hidden.  Light samples find it, and directions that find it by chance.
  SceneDescription d = testing::description(0);
  d.shapes = {testing::emissive(testing::patch({-1, -1, 1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, 1}), 7),
              testing::patch({0, -1, 0.9}, {0, 1, 0.9}, {1, -1, 0.9}, {1, 1, 0.9})};
  const auto scene = build(std::move(d));
  IrradianceSettings settings{.samples_per_block = 8, .block_count = 4, .bounces = 1};
  settings.per_light = true;
  const IrradianceResult r = estimate_irradiance(*scene, std::vector{at(0, 0, 0)}, settings, {});
  EXPECT_FALSE(r.points[0].exact);
  EXPECT_EQ(r.per_light[0].illuminance_lx.lower, r.points[0].illuminance_lx.lower);
  EXPECT_EQ(r.per_light[0].illuminance_lx.upper, r.points[0].illuminance_lx.upper);
}

TEST(Irradiance, OfZeroSamplesBoundsTheLightThatTheyMissed) {
  // A lamp of 1 m2 above a lid with a hole of 1 mm that the samples miss.
  SceneDescription d = testing::description(0);
  d.shapes = {testing::emissive(testing::patch({0, 0, 4}, {0, 1, 4}, {1, 0, 4}, {1, 1, 4}), 7),
              testing::floor(9, 2)};
  const auto scene = build(std::move(d));
  const IrradianceEstimate e = one(*scene, at(0.5f, 0.5f, 0), direct(16, 4));
  EXPECT_EQ(e.irradiance_lx.g, 0);
  EXPECT_FALSE(e.exact);
  // Unshadowed: about L A / d^2 = 7/16, which one sample may exceed slightly; three of 64 samples.
  EXPECT_GT(e.zero_bound_lx, 0.5 * 7 / 16 * 3 / 64);
  EXPECT_LT(e.zero_bound_lx, 2 * 7.0 / 16 * 3 / 64);
  // Towards the other side no sample could have found light.
  EXPECT_EQ(one(*scene, at(0.5f, 0.5f, 0, {0, 0, -1}), direct(16, 4)).zero_bound_lx, 0);
}

TEST(Irradiance, OfZeroSamplesBoundsADimSky) {
  // 10 cd/m2 towards +y and 1 towards -y, where the receiver faces a wall.  The light's own samples
  // all come from the bright half, behind the receiver.
  SceneDescription d = testing::description(0);
  const double far = 1e4;
  d.shapes = {testing::patch({-far, 0, -far}, {far, 0, -far}, {-far, 0, far}, {far, 0, far})};
  d.lights.resize(1);
  d.lights[0].params = ImageInfiniteLightParams{
      *SphereMap::create(*Image::create(1, 2, {Rgbf(10), Rgbf(1)}),
                         SphereMapping::kLatitudeLongitude, ImageFilter::kNearest)};
  const IrradianceEstimate e = one(*build(std::move(d)), at(0, 1, 0, {0, -1, 0}), direct(16, 4));
  EXPECT_EQ(e.irradiance_lx.g, 0);
  EXPECT_FALSE(e.exact);
  // If more than this share of samples were pi lx, 64 samples would miss them all once in twenty
  // times.
  EXPECT_NEAR(e.zero_bound_lx, -std::log(0.05) / 64 * std::numbers::pi, 1e-5);
}

TEST(Irradiance, OfZeroSamplesBoundsTheMissedLightBesideExactLight) {
  // As above, plus a lamp of 100 cd under the lid: 100 lx at 1 m, exactly.
  SceneDescription d = testing::description(0);
  d.shapes = {testing::emissive(testing::patch({0, 0, 4}, {0, 1, 4}, {1, 0, 4}, {1, 1, 4}), 7),
              testing::floor(9, 2)};
  d.lights = {testing::point_light({0.5, 0.5, 1}, 100)};
  const IrradianceEstimate e = one(*build(std::move(d)), at(0.5f, 0.5f, 0), direct(16, 4));
  EXPECT_NEAR(e.irradiance_lx.g, 100, 1e-4);
  EXPECT_FALSE(e.exact);
  EXPECT_GT(e.zero_bound_lx, 100 + 0.5 * 7 / 16 * 3 / 64);
  EXPECT_LT(e.zero_bound_lx, 100 + 2 * 7.0 / 16 * 3 / 64);
}

TEST(Irradiance, HasNoStandardErrorFromOneReplicate) {
  SceneDescription d = testing::description();
  d.lights = {{UniformInfiniteLightParams{Rgb(2)}, {}}};
  const IrradianceEstimate e = one(*build(std::move(d)), at(0, 0, 0), sampled(16, 1));
  EXPECT_TRUE(std::isinf(e.illuminance_error_lx));
}

TEST(Irradiance, OfDeltaLightsIsTheSameWithATargetAndWithWavelengths) {
  SceneDescription d = testing::description();
  d.shapes = {testing::floor(9), testing::floor(1, 2)};
  d.lights = {testing::point_light({3, 0, 4}, 100),
              {DistantLightParams{.to_light = {1, 2, 3}, .illuminance_lx = Rgb(40)}, {}},
              {SpotLightParams{.position_m = {-2, 1, 3},
                               .axis = {0, 0, -1},
                               .intensity_cd = Rgb(30),
                               .cone_half_angle_rad = 0.8},
               {}}};
  const auto scene = build(std::move(d));
  std::vector<IrradiancePoint> points;
  for (int i = 0; i < 150; ++i)
    points.push_back(at(i % 13 - 6.0F, i % 11 - 5.0F, 0, {0, 0, i % 5 == 0 ? -1.0 : 1.0}));
  IrradianceSettings settings = direct(1, 16);
  settings.per_light = true;
  const IrradianceResult plain = estimate_irradiance(*scene, points, settings, {});
  const std::vector<double> wavelengths{555};
  settings.wavelengths_nm = wavelengths;
  const IrradianceResult spectral = estimate_irradiance(*scene, points, settings, {});
  settings.target = TargetError{.relative = 0.01};
  const IrradianceResult of_target = estimate_irradiance(*scene, points, settings, {});
  EXPECT_GT(plain.work.shadow_rays, points.size());
  // Points are timed only with a target.
  for (const PointCost& cost : of_target.costs) EXPECT_GT(cost.time_s, 0);
  for (const PointCost& cost : plain.costs) EXPECT_EQ(cost.time_s, 0);
  for (const IrradianceResult& other : {spectral, of_target}) {
    EXPECT_EQ(plain.work.shadow_rays, other.work.shadow_rays);
    for (std::size_t p = 0; p < points.size(); ++p) {
      EXPECT_TRUE(other.points[p].exact);
      EXPECT_EQ(plain.points[p].irradiance_lx, other.points[p].irradiance_lx) << p;
      EXPECT_EQ(plain.costs[p].rays, other.costs[p].rays) << p;
      EXPECT_EQ(other.costs[p].samples, 0U);
      for (std::size_t l = p * 3; l < p * 3 + 3; ++l)
        EXPECT_EQ(plain.per_light[l].irradiance_lx, other.per_light[l].irradiance_lx) << l;
    }
  }
}

TEST(Irradiance, StopsOnRequest) {
  const auto scene = build(lamps(12));
  std::stop_source stop;
  stop.request_stop();
  const IrradiancePoint p = at(0, 0, 0);
  EXPECT_TRUE(
      estimate_irradiance(*scene, std::span(&p, 1), direct(1u << 30), stop.get_token()).stopped);
}

}  // namespace
}  // namespace lucerna

// What every light owes: rays that leave it, bounds, and approximate power.
#include <array>
#include <cmath>
#include <optional>

#include "lights/models/light_tree.h"
#include "tests/lights/contract/contract_suite.h"
#include "tests/lights/contract/emission_checks.h"

namespace lucerna::testing {
namespace {

class EmittingLight : public ContractTest {};

TEST_P(EmittingLight, RaysAgreeWithEvaluation) {
  const auto emitted = [&](const Vec3& position, const Vec3& w) {
    return c.emitted ? c.emitted(position, w) : c.value(position + w, -w);
  };
  // The value is looked up from the ray's rounded position and direction.
  const Verdict verdict = check_emission_agrees(
      [&](Vec2 up, Vec2 ud) { return light->sample_le(up, ud, kScene); },
      [&](const Vec3& p, const Vec3& w) { return light->pdf_le(p, w, kScene); }, emitted,
      c.tolerance, 1e-9);
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TEST_P(EmittingLight, PowerEqualsQuadratureAndApproximatePowerStatesItsError) {
  const Power power = light->power(kScene), approximate = light->power_approximate(kScene);
  const Rgb lumens = c.power_lm();
  EXPECT_LE(relative_difference(power.lumens, lumens), c.power_tolerance);
  EXPECT_GE(power.error_lumens, 0);
  const Verdict verdict = check_stated_error(approximate, lumens, c.power_tolerance);
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
  EXPECT_GE(approximate.error_lumens, power.error_lumens);
}

TEST_P(EmittingLight, MeanOfRaysIsThePower) {
  const Power power = light->power(kScene);
  const Verdict verdict = check_emission_mean(
      [&](Vec2 up, Vec2 ud) { return light->sample_le(up, ud, kScene); }, power.lumens,
      1e-6 + power.error_lumens / std::fmax(luminance(power.lumens), 1e-300));
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TEST_P(EmittingLight, ExtremeSampleValuesGiveValidRays) {
  constexpr std::array kExtremes{0.0, 1 - 0x1p-24, 1.0};
  for (int i = 0; i < 81; ++i) {
    const auto at = [&](int n) { return kExtremes[i / n % 3]; };
    const Verdict verdict =
        check_well_formed(light->sample_le({at(27), at(9)}, {at(3), at(1)}, kScene));
    EXPECT_TRUE(verdict.ok()) << verdict.failure << " at " << i;
  }
}

TEST_P(EmittingLight, RaysOfOtherLightsHaveNoDensity) {
  RandomU random(12);
  const EmissionPdf none{};
  for (int i = 0; i < 100; ++i) {
    const Vec2 u = random.pair();
    const auto s = light->sample_le(u, random.pair(), kScene);
    EXPECT_EQ(light->pdf_le(s.origin + Vec3{20, 30, -50}, s.direction, kScene), none);
    for (const Vec3& nowhere :
         {Vec3{NAN, 0, 1}, {NAN, s.direction.y, s.direction.z}, {NAN, NAN, NAN}}) {
      EXPECT_EQ(light->pdf_le(nowhere, s.direction, kScene), none);
      EXPECT_EQ(light->pdf_le(s.origin, nowhere, kScene), none);
    }
  }
}

INSTANTIATE_CONTRACT(EmittingLight, !c.receivers_only);

class EmittingSurface : public ContractTest {};

TEST_P(EmittingSurface, PositionsFollowTheDensity) {
  RandomU random(0xe3);
  const Vec2 ud{0.25, 0.625};
  // A light that emits in proportion to a picture has one density of positions for all directions.
  // So one direction is enough.
  const Vec3 w = light->sample_le({0.5, 0.5}, ud, kScene).direction;
  const Verdict verdict = check_follows_on_square(
      [&]() -> std::optional<Vec2> {
        const auto s = light->sample_le(random.pair(), ud, kScene);
        if (s.reason != NoLight::kNone) return std::nullopt;
        return c.emission_where(s.origin, s.direction);
      },
      [&](double x, double y) {
        const Vec3 p = c.emission_position(w, x, y);
        const Vec3 leaving = c.emission_direction ? c.emission_direction(p) : w;
        return light->pdf_le(p, leaving, kScene).position.per_m2 * c.emission_area_m2;
      });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

INSTANTIATE_CONTRACT(EmittingSurface, !c.receivers_only && c.emission_position);

class EmittingDirections : public ContractTest {};

TEST_P(EmittingDirections, DirectionsFollowTheDensity) {
  for (const Vec2 up : {Vec2{0.5, 0.5}, Vec2{0.125, 0.75}}) {
    RandomU random(0xe4);
    const Vec3 origin = light->sample_le(up, {0.4, 0.4}, kScene).origin;
    const Region region = c.emission_region(origin);
    const Verdict verdict = check_follows_on_square(
        [&]() -> std::optional<Vec2> {
          const auto s = light->sample_le(up, random.pair(), kScene);
          if (s.reason != NoLight::kNone) return std::nullopt;
          return region.where(s.direction);
        },
        [&](double x, double y) {
          const Vec3 w = region.at(x, y);
          // Rays from infinitely far start where their direction requires.
          const Vec3 p = c.enters_by_scene_disk ? c.emission_position(w, 0.5, 0.5) : origin;
          return light->pdf_le(p, w, kScene).direction.per_sr * region.solid_angle_sr();
        });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

INSTANTIATE_CONTRACT(EmittingDirections, !c.receivers_only && c.emission_region);

class BoundedLight : public ContractTest {};

TEST_P(BoundedLight, BoundsReachWhereverLightArrives) {
  for (const Placement& placement : {Placement{}, moved()}) {
    const auto placed = c.make(placement);
    const auto bounds = placed->bounds();
    ASSERT_TRUE(bounds.has_value());
    const Verdict verdict = check_bounds_reach(
        *bounds, (bounds->lower + bounds->upper) * 0.5, placement.length(c.size),
        [&](const Vec3& p, Vec2 u) { return placed->sample_li(p, u).reason == NoLight::kNone; });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

// Like in a scene: beside another light.
TEST_P(BoundedLight, ATreeChoosesItWhereverLightArrives) {
  const auto placed = c.make(moved());
  const LightBounds bounds = *placed->bounds();
  EXPECT_LE(bounds.normals_rad, bounds.cone_rad);
  EXPECT_GE(bounds.normals_rad + std::numbers::pi / 2, bounds.two_sided ? 0 : bounds.cone_rad);
  const Vec3 center = (bounds.lower + bounds.upper) * 0.5;
  const double size = moved().length(c.size);
  const Vec3 aside = center + Vec3{size, 3 * size, 0};
  const LightTree tree = *LightTree::create(std::vector<LightTree::Item>{
      {bounds, 1}, {{.lower = aside, .upper = aside, .cone_rad = std::numbers::pi}, 1}});
  const Verdict verdict = check_reach(
      [&](const Vec3& p) { return tree.probability(p, 0) > 0; }, center, size,
      [&](const Vec3& p, Vec2 u) { return placed->sample_li(p, u).reason == NoLight::kNone; });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TEST_P(BoundedLight, BoundsHoldTheLight) {
  const auto placed = c.make(moved());
  const Verdict verdict = check_bounds_hold(
      *placed->bounds(), [&](Vec2 up, Vec2 ud) { return placed->sample_le(up, ud, kScene); });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TEST_P(BoundedLight, BoundsLeaveOutPlacesOutsideTheCone) {
  const auto bounds = light->bounds();
  const Vec3 center = (bounds->lower + bounds->upper) * 0.5;
  RandomU random(13);
  int left_out = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec2 at = random.pair();
    left_out += bounds->reaches(center + Region{}.at(at.x, at.y) * (10 * c.size)) ? 0 : 1;
  }
  EXPECT_EQ(left_out > 0, c.confined);
}

INSTANTIATE_CONTRACT(BoundedLight, !c.receivers_only && c.distance_to_surface);

class UnboundedLight : public ContractTest {};

// A light at infinity is chosen by its illuminance: its flux over its cross-section.
TEST_P(UnboundedLight, HasACrossSectionAndNoBounds) {
  EXPECT_FALSE(light->bounds().has_value());
  const std::optional<double> section_m2 = light->cross_section_m2(kScene);
  ASSERT_TRUE(section_m2.has_value());
  EXPECT_GT(*section_m2, 0);
}

// Rays that enter by the scene's sphere cannot start where that is a point.  Rays that start on a
// portal do not use the sphere.
TEST_P(UnboundedLight, ASceneWithoutExtentGetsRaysOfPortalsOnly) {
  const SceneSphere none{{}, 0};
  RandomU random(16);
  for (int i = 0; i < 100; ++i) {
    const Vec2 up = random.pair(), ud = random.pair();
    const auto s = light->sample_le(up, ud, none);
    ASSERT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if (c.enters_by_scene_disk) {
      EXPECT_NE(s.reason, NoLight::kNone);
      EXPECT_EQ(light->pdf_le({0, 0, 0}, {0, 0, 1}, none), EmissionPdf{});
    } else {
      const auto same = light->sample_le(up, ud, kScene);
      EXPECT_EQ(s.reason, same.reason);
      EXPECT_EQ(s.origin, same.origin);
      EXPECT_EQ(s.direction, same.direction);
      if (s.reason != NoLight::kNone) continue;
      const EmissionPdf densities = light->pdf_le(s.origin, s.direction, none);
      EXPECT_EQ(densities, light->pdf_le(s.origin, s.direction, kScene));
      EXPECT_GT(densities.position.per_m2, 0);
    }
  }
}

INSTANTIATE_CONTRACT(UnboundedLight, !c.distance_to_surface);

}  // namespace
}  // namespace lucerna::testing

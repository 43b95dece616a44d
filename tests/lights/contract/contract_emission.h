// The contract of rays that leave lights, of bounds and of approximate power, as typed suites.
// They take the cases of contract.h with these additional members:
//
//   // Lights whose rays start anywhere on a surface: a map of the unit square onto it that keeps
//   // area, its inverse, and the area [m2].  A ray leaves towards `w`.
//   static Vec3 emission_position(const Vec3& w, double x, double y);
//   static Vec2 emission_where(const Vec3& position, const Vec3& w);
//   static double emission_area_m2();
//   // Optional, where a direction leaves only part of the surface: one that leaves `position`.
//   static Vec3 emission_direction(const Vec3& position);
//   // A cone that holds all directions in which light leaves `position`.
//   static Region emission_region(const Vec3& position);
//   // Optional: value of the ray; without it the case's value() one metre along the ray.
//   static Rgb emitted(const Vec3& position, const Vec3& direction);
//   // Local lights: whether the bounds must report some places as dark.
//   static constexpr bool kConfined;
//
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, EmittingLight, MyCase);        // every light
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, EmittingSurface, MyCase);      // position not certain
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, EmittingDirections, MyCase);   // direction not certain
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, BoundedLight, MyCase);         // or: UnboundedLight
//
// Lights at infinity take position and area from SceneDiskCase.
#pragma once

#include <algorithm>
#include <optional>

#include "lights/models/light_tree.h"
#include "tests/lights/contract/contract.h"
#include "tests/lights/contract/emission_checks.h"

namespace lucerna::testing {

/// Rays from infinitely far enter through a disk of radius 4 that faces their direction and touches
/// the sphere of CaseDefaults::scene().  Polar coordinates keep area in r^2.
struct SceneDiskCase {
  static Vec3 emission_position(const Vec3& w, double x, double y) {
    const double r = std::sqrt(x), phi = 2 * std::numbers::pi * y;
    return Frame::around(w).world_from_local({r * std::cos(phi), r * std::sin(phi), -1}) * 4.0;
  }
  static Vec2 emission_where(const Vec3& position, const Vec3& w) {
    const Vec3 p = Frame::around(w).local_from_world(position) * 0.25;
    const double y = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
    // Outside of the disk's plane there is no place for it.
    if (std::fabs(p.z + 1) > 1e-5) return {NAN, NAN};
    return {p.x * p.x + p.y * p.y, y < 0 ? y + 1 : y};
  }
  static double emission_area_m2() { return 16 * std::numbers::pi; }
  static Region emission_region(const Vec3&) { return {}; }
};

// The tests are in contract_emission.cpp.
namespace emitting_light {
void rays_agree_with_evaluation(const LightCase& c);
void float_rays_agree_with_their_densities(const LightCase& c);
void mean_of_rays_is_the_power(const LightCase& c);
void extreme_sample_values_give_valid_rays(const LightCase& c);
void rays_of_other_lights_have_no_density(const LightCase& c);
void approximate_power_states_its_error(const LightCase& c);
}  // namespace emitting_light

namespace emitting_surface {
void positions_follow_the_density(const LightCase& c);
}  // namespace emitting_surface

namespace emitting_directions {
void directions_follow_the_density(const LightCase& c);
}  // namespace emitting_directions

namespace bounded_light {
void bounds_reach_wherever_light_arrives(const LightCase& c);
void a_tree_chooses_it_wherever_light_arrives(const LightCase& c);
void bounds_hold_the_light(const LightCase& c);
void bounds_leave_out_the_places_that_a_cone_does(const LightCase& c);
}  // namespace bounded_light

namespace unbounded_light {
void has_a_cross_section_and_no_bounds(const LightCase& c);
void a_scene_without_extent_gets_rays_of_portals_only(const LightCase& c);
}  // namespace unbounded_light

template <typename Case>
class EmittingLight : public ::testing::Test {
 protected:
  EmittingLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("EmittingLight");
};
TYPED_TEST_SUITE_P(EmittingLight);

TYPED_TEST_P(EmittingLight, RaysAgreeWithEvaluation) {
  emitting_light::rays_agree_with_evaluation(light_case<TypeParam>());
}

TYPED_TEST_P(EmittingLight, FloatRaysAgreeWithTheirDensities) {
  emitting_light::float_rays_agree_with_their_densities(light_case<TypeParam>());
}

TYPED_TEST_P(EmittingLight, MeanOfRaysIsThePower) {
  emitting_light::mean_of_rays_is_the_power(light_case<TypeParam>());
}

TYPED_TEST_P(EmittingLight, ExtremeSampleValuesGiveValidRays) {
  emitting_light::extreme_sample_values_give_valid_rays(light_case<TypeParam>());
}

TYPED_TEST_P(EmittingLight, RaysOfOtherLightsHaveNoDensity) {
  emitting_light::rays_of_other_lights_have_no_density(light_case<TypeParam>());
}

TYPED_TEST_P(EmittingLight, ApproximatePowerStatesItsError) {
  emitting_light::approximate_power_states_its_error(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(EmittingLight, RaysAgreeWithEvaluation,
                            FloatRaysAgreeWithTheirDensities, MeanOfRaysIsThePower,
                            ExtremeSampleValuesGiveValidRays, RaysOfOtherLightsHaveNoDensity,
                            ApproximatePowerStatesItsError);

template <typename Case>
class EmittingSurface : public ::testing::Test {
 protected:
  EmittingSurface() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("EmittingSurface");
};
TYPED_TEST_SUITE_P(EmittingSurface);

TYPED_TEST_P(EmittingSurface, PositionsFollowTheDensity) {
  emitting_surface::positions_follow_the_density(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(EmittingSurface, PositionsFollowTheDensity);

template <typename Case>
class EmittingDirections : public ::testing::Test {
 protected:
  EmittingDirections() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("EmittingDirections");
};
TYPED_TEST_SUITE_P(EmittingDirections);

TYPED_TEST_P(EmittingDirections, DirectionsFollowTheDensity) {
  emitting_directions::directions_follow_the_density(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(EmittingDirections, DirectionsFollowTheDensity);

template <typename Case>
class BoundedLight : public ::testing::Test {
 protected:
  BoundedLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("BoundedLight");
};
TYPED_TEST_SUITE_P(BoundedLight);

TYPED_TEST_P(BoundedLight, BoundsReachWhereverLightArrives) {
  bounded_light::bounds_reach_wherever_light_arrives(light_case<TypeParam>());
}

// Like in a scene: beside another light, in double.
TYPED_TEST_P(BoundedLight, ATreeChoosesItWhereverLightArrives) {
  bounded_light::a_tree_chooses_it_wherever_light_arrives(light_case<TypeParam>());
}

TYPED_TEST_P(BoundedLight, BoundsHoldTheLight) {
  bounded_light::bounds_hold_the_light(light_case<TypeParam>());
}

TYPED_TEST_P(BoundedLight, BoundsLeaveOutPlacesOutsideTheCone) {
  bounded_light::bounds_leave_out_the_places_that_a_cone_does(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(BoundedLight, BoundsReachWhereverLightArrives,
                            ATreeChoosesItWhereverLightArrives, BoundsHoldTheLight,
                            BoundsLeaveOutPlacesOutsideTheCone);

template <typename Case>
class UnboundedLight : public ::testing::Test {
 protected:
  UnboundedLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("UnboundedLight");
};
TYPED_TEST_SUITE_P(UnboundedLight);

// A light at infinity is chosen by its illuminance: its flux over its cross-section.
TYPED_TEST_P(UnboundedLight, HasACrossSectionAndNoBounds) {
  unbounded_light::has_a_cross_section_and_no_bounds(light_case<TypeParam>());
}

// Rays that enter by the scene's sphere cannot start where that is a point.  Rays that start on a
// portal do not use the sphere.
TYPED_TEST_P(UnboundedLight, ASceneWithoutExtentGetsRaysOfPortalsOnly) {
  unbounded_light::a_scene_without_extent_gets_rays_of_portals_only(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(UnboundedLight, HasACrossSectionAndNoBounds,
                            ASceneWithoutExtentGetsRaysOfPortalsOnly);

}  // namespace lucerna::testing

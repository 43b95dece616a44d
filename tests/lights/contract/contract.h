// The contract that every light model keeps, as one typed suite.  A light takes part through a
// small struct (a "case").  The case builds the light and states the expected answers, computed
// without the light's code:
//
//   struct MyCase : CaseDefaults {
//     using Light = ...;
//     // Builds the light with all its lengths times 2^exponent, then moved.
//     static Light make(const Placement& placement);
//     // Receivers, in the light's own space; floats hold them exactly.
//     static std::vector<Vec3> receivers();
//     // What arrives at `receiver` along the unit vector `wi`: radiance; for a delta light, the
//     // illuminance on a surface that faces it.  Computed from first principles in double.
//     static Rgb value(const Vec3& receiver, const Vec3& wi);
//     // Lights with a density only: a cone of directions that holds all of the light.  If
//     directions
//     // crowd at an edge, the test's own type instead.  It has Region's `at`, `where` and
//     // `element_sr(x, y)`, the solid angle of a unit of the square at (x, y).
//     static Region region(const Vec3& receiver);
//     // Lights with a position only: the distance of `p` from the light's surface [m].
//     static double distance_to_surface(const Vec3& p);
//     // The power, by the test's own quadrature, and the relative error of that quadrature.
//     static Rgb power_by_quadrature();
//   };
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, AnyLight, MyCase);       // every light
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, LightWithDensity, MyCase);  // or: DeltaLight
//   INSTANTIATE_TYPED_TEST_SUITE_P(MyLight, LocalLight, MyCase);     // unless infinitely far
#pragma once

#include <gtest/gtest.h>

#include "tests/lights/contract/contract_case.h"
#include "tests/lights/contract/contract_checks.h"
#include "tests/lights/contract/takes_part.h"

namespace lucerna::testing {

struct CaseDefaults {
  /// A value is proportional to length to this power: -2 for lights with an intensity, 0 for lights
  /// with a radiance.
  static constexpr int kValueLengthPower = 0;
  /// Power is proportional to length to this power: 2 for radiance or illuminance, 0 for intensity.
  static constexpr int kPowerLengthPower = 2;
  /// Relative error of a reported density against an evaluated one, and of a value.
  static constexpr double kTolerance = 1e-12;
  static constexpr double kPowerTolerance = 1e-6;
  /// The size of the light [m].  The far field begins at a multiple of it.
  static constexpr double kSize = 1;
  /// The centre of the whole light.
  static Vec3 centre() { return {}; }
  /// In the far field, illuminance is proportional to distance to this power: 0 for parallel rays.
  static constexpr int kFarFieldLengthPower = -2;
  /// Whether no light leaves the shape: then there is no far field.
  static constexpr bool kEnclosed = false;
  /// The direction of the far field from the light's centre, a unit vector.
  static Vec3 far_direction() { return {0, 0, 1}; }
  static SceneSphere scene() { return {{}, 4}; }
  /// A receiver at `p`, in the space of the placed light.
  static Receiver receiver(const Vec3& p, const Placement&) { return p; }
};

inline Placement moved() {
  return {Transform::translate({3, -2, 5}) * *Transform::rotate(2, {1, -3, 2}), 0};
}

// The tests are in contract.cpp.
namespace any_light {
void samples_agree_with_evaluation(const LightCase& c);
void extreme_sample_values_give_valid_samples(const LightCase& c);
void receivers_that_are_not_finite_give_a_reason(const LightCase& c);
void power_equals_quadrature(const LightCase& c);
void rigid_motion_changes_only_the_frame(const LightCase& c);
void scaling_by_powers_of_two_changes_no_bit(const LightCase& c);
}  // namespace any_light

namespace light_with_density {
void density_integrates_to_the_sampled_probability(const LightCase& c);
void samples_follow_the_density(const LightCase& c);
}  // namespace light_with_density

namespace delta_light {
void has_no_density_and_says_so(const LightCase& c);
}  // namespace delta_light

namespace local_light {
void far_field_falls_off_with_the_square_of_distance(const LightCase& c);
void sampled_points_lie_on_the_light(const LightCase& c);
}  // namespace local_light

template <typename Case>
class AnyLight : public ::testing::Test {
 protected:
  AnyLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("AnyLight");
};
TYPED_TEST_SUITE_P(AnyLight);

TYPED_TEST_P(AnyLight, SamplesAgreeWithEvaluation) {
  any_light::samples_agree_with_evaluation(light_case<TypeParam>());
}

TYPED_TEST_P(AnyLight, ExtremeSampleValuesGiveValidSamples) {
  any_light::extreme_sample_values_give_valid_samples(light_case<TypeParam>());
}

TYPED_TEST_P(AnyLight, ReceiversThatAreNotFiniteGiveAReason) {
  any_light::receivers_that_are_not_finite_give_a_reason(light_case<TypeParam>());
}

TYPED_TEST_P(AnyLight, PowerEqualsQuadrature) {
  any_light::power_equals_quadrature(light_case<TypeParam>());
}

TYPED_TEST_P(AnyLight, RigidMotionChangesOnlyTheFrame) {
  any_light::rigid_motion_changes_only_the_frame(light_case<TypeParam>());
}

TYPED_TEST_P(AnyLight, ScalingByPowersOfTwoChangesNoBit) {
  any_light::scaling_by_powers_of_two_changes_no_bit(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(AnyLight, SamplesAgreeWithEvaluation,
                            ExtremeSampleValuesGiveValidSamples,
                            ReceiversThatAreNotFiniteGiveAReason, PowerEqualsQuadrature,
                            RigidMotionChangesOnlyTheFrame, ScalingByPowersOfTwoChangesNoBit);

template <typename Case>
class LightWithDensity : public ::testing::Test {
 protected:
  LightWithDensity() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("LightWithDensity");
};
TYPED_TEST_SUITE_P(LightWithDensity);

TYPED_TEST_P(LightWithDensity, DensityIntegratesToTheSampledProbability) {
  light_with_density::density_integrates_to_the_sampled_probability(light_case<TypeParam>());
}

TYPED_TEST_P(LightWithDensity, SamplesFollowTheDensity) {
  light_with_density::samples_follow_the_density(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(LightWithDensity, DensityIntegratesToTheSampledProbability,
                            SamplesFollowTheDensity);

template <typename Case>
class DeltaLight : public ::testing::Test {
 protected:
  DeltaLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("DeltaLight");
};
TYPED_TEST_SUITE_P(DeltaLight);

TYPED_TEST_P(DeltaLight, HasNoDensityAndReportsIt) {
  delta_light::has_no_density_and_says_so(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(DeltaLight, HasNoDensityAndReportsIt);

template <typename Case>
class LocalLight : public ::testing::Test {
 protected:
  LocalLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Case>("LocalLight");
};
TYPED_TEST_SUITE_P(LocalLight);

TYPED_TEST_P(LocalLight, FarFieldFallsOffWithTheSquareOfDistance) {
  local_light::far_field_falls_off_with_the_square_of_distance(light_case<TypeParam>());
}

TYPED_TEST_P(LocalLight, SampledPointsLieOnTheLight) {
  local_light::sampled_points_lie_on_the_light(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(LocalLight, FarFieldFallsOffWithTheSquareOfDistance,
                            SampledPointsLieOnTheLight);

}  // namespace lucerna::testing

// The contract that every light model keeps, as one typed suite.  A light takes part through a
// small struct (a "case") that says how to build it and, independently of its code, what it should
// answer:
//
//   struct MyCase : CaseDefaults {
//     template <typename Real> using Light = ...;
//     // Builds the light with all its lengths times 2^exponent, then moved.
//     template <typename Real> static Light<Real> make(const Placement& placement);
//     // Positions to try, in the light's own space; floats hold them exactly.
//     static std::vector<Vec3<double>> receivers();
//     // What arrives at `receiver` along the unit vector `wi`: radiance, for a delta light the
//     // illuminance on a surface that faces it.  Computed from first principles in double.
//     static Rgb<double> value(const Vec3<double>& receiver, const Vec3<double>& wi);
//     // A cone of directions that holds all of the light (lights with a density only); or, of
//     // directions that crowd at an edge, a type of the test's own with Region's `at`, `where` and
//     // `element_sr(x, y)`, the solid angle that one unit of the square has there.
//     static Region region(const Vec3<double>& receiver);
//     // How far `p` lies from the light's surface [m] (lights with a position only).
//     static double distance_to_surface(const Vec3<double>& p);
//     // The power, by quadrature in code of the test's own, and that quadrature's relative error.
//     static Rgb<double> power_by_quadrature();
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
  /// Value is proportional to length to this power: -2 where intensity is given, 0 for radiance.
  static constexpr int kValueLengthPower = 0;
  /// Power likewise: 2 where radiance or illuminance is given, 0 for intensity.
  static constexpr int kPowerLengthPower = 2;
  /// Relative error of float against double, of told against evaluated density, and of value.
  static constexpr double kTolerance = 1e-5;
  static constexpr double kPowerTolerance = 1e-6;
  /// The size of the light [m]: what its distance is compared with in the far field.
  static constexpr double kSize = 1;
  /// Where the light stands as a whole.
  static Vec3<double> centre() { return {}; }
  /// Illuminance falls off with distance to this power far away: 0 for parallel rays.
  static constexpr int kFarFieldLengthPower = -2;
  /// Whether the light keeps all its light within itself: there is no far field then.
  static constexpr bool kEnclosed = false;
  /// From where the light shines at its far field, a unit vector from the light's centre.
  static Vec3<double> far_direction() { return {0, 0, 1}; }
  static SceneSphere scene() { return {{}, 4}; }
};

inline Placement moved() {
  return {Transform::translate({3, -2, 5}) * *Transform::rotate(2, {1, -3, 2}), 0};
}

// The tests, in contract.cpp.
namespace any_light {
void samples_agree_with_evaluation(const LightCase& c);
void float_agrees_with_double(const LightCase& c);
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
 public:
  using Float = typename Case::template Light<float>;
  using Double = typename Case::template Light<double>;

 protected:
  AnyLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart = takes_part<Float>("AnyLight");
};
TYPED_TEST_SUITE_P(AnyLight);

TYPED_TEST_P(AnyLight, SamplesAgreeWithEvaluation) {
  any_light::samples_agree_with_evaluation(light_case<TypeParam>());
}

TYPED_TEST_P(AnyLight, FloatAgreesWithDouble) {
  any_light::float_agrees_with_double(light_case<TypeParam>());
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

REGISTER_TYPED_TEST_SUITE_P(AnyLight, SamplesAgreeWithEvaluation, FloatAgreesWithDouble,
                            ExtremeSampleValuesGiveValidSamples,
                            ReceiversThatAreNotFiniteGiveAReason, PowerEqualsQuadrature,
                            RigidMotionChangesOnlyTheFrame, ScalingByPowersOfTwoChangesNoBit);

template <typename Case>
class LightWithDensity : public ::testing::Test {
 protected:
  LightWithDensity() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("LightWithDensity");
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
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("DeltaLight");
};
TYPED_TEST_SUITE_P(DeltaLight);

TYPED_TEST_P(DeltaLight, HasNoDensityAndSaysSo) {
  delta_light::has_no_density_and_says_so(light_case<TypeParam>());
}

REGISTER_TYPED_TEST_SUITE_P(DeltaLight, HasNoDensityAndSaysSo);

template <typename Case>
class LocalLight : public ::testing::Test {
 protected:
  LocalLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("LocalLight");
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

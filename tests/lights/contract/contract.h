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
  const auto light = TypeParam::template make<float>({});
  for (const auto& receiver : TypeParam::receivers()) {
    const Vec3<float> r(receiver);
    const Verdict verdict =
        check_sample_agrees([&](Vec2<float> u) { return light.sample_li(r, u); },
                            [&](const Vec3<float>& wi) { return light.pdf_li(r, wi).per_sr; },
                            [&](const Vec3<double>& wi) { return TypeParam::value(receiver, wi); },
                            TypeParam::kTolerance);
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

TYPED_TEST_P(AnyLight, FloatAgreesWithDouble) {
  const auto light = TypeParam::template make<float>({});
  const auto reference = TypeParam::template make<double>({});
  RandomU random(1);
  for (const auto& receiver : TypeParam::receivers()) {
    for (int i = 0; i < 200; ++i) {
      const Vec2<float> u = random.pair();
      const auto s = light.sample_li(Vec3<float>(receiver), u);
      const auto d = reference.sample_li(receiver, {u.x, u.y});
      ASSERT_EQ(s.reason, d.reason);
      if (s.reason != NoLight::kNone) continue;
      EXPECT_LE(relative_difference(s.pdf.per_sr, d.pdf.per_sr), TypeParam::kTolerance);
      EXPECT_LE(relative_difference(Rgb<double>(s.value), d.value), TypeParam::kTolerance);
      EXPECT_LE(relative_difference(s.distance, d.distance), TypeParam::kTolerance);
      EXPECT_LE(distance_between(Vec3<double>(s.wi), d.wi), TypeParam::kTolerance);
      EXPECT_EQ(s.primitive, d.primitive);
    }
  }
}

TYPED_TEST_P(AnyLight, ExtremeSampleValuesGiveValidSamples) {
  const auto light = TypeParam::template make<float>({});
  for (const auto& receiver : TypeParam::receivers()) {
    for (const float x : {0.F, 1 - 0x1p-24F, 1.F}) {
      for (const float y : {0.F, 1 - 0x1p-24F, 1.F}) {
        const auto s = light.sample_li(Vec3<float>(receiver), {x, y});
        const Verdict verdict = check_well_formed(s);
        EXPECT_TRUE(verdict.ok()) << verdict.failure << " at u = (" << x << ", " << y << ")";
      }
    }
  }
}

TYPED_TEST_P(AnyLight, ReceiversThatAreNotFiniteGiveAReason) {
  const auto light = TypeParam::template make<float>({});
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    for (const Vec3<float>& r : {Vec3<float>{bad, 0, 0}, {0, bad, 0}, {0, 0, bad}}) {
      const auto s = light.sample_li(r, {0.5F, 0.5F});
      EXPECT_TRUE(s.reason == NoLight::kOutOfRange || s.reason == NoLight::kDegenerate);
      EXPECT_TRUE(check_well_formed(s).ok());
      EXPECT_EQ(light.pdf_li(r, {0, 0, 1}).per_sr, 0);
    }
  }
}

TYPED_TEST_P(AnyLight, PowerEqualsQuadrature) {
  const auto light = TypeParam::template make<float>({});
  const Power power = light.power(TypeParam::scene());
  EXPECT_LE(relative_difference(power.lumens, TypeParam::power_by_quadrature()),
            TypeParam::kPowerTolerance);
  EXPECT_GE(power.error_lumens, 0);
}

TYPED_TEST_P(AnyLight, RigidMotionChangesOnlyTheFrame) {
  const Placement placement = moved();
  const auto light = TypeParam::template make<double>({});
  const auto elsewhere = TypeParam::template make<double>(placement);
  RandomU random(2);
  for (const auto& receiver : TypeParam::receivers()) {
    for (int i = 0; i < 200; ++i) {
      // The warps' frames may turn with the motion: the same direction is asked for, not the same
      // u.
      const auto s = light.sample_li(receiver, random.pair<double>());
      const auto m = elsewhere.sample_li(placement.point(receiver), random.pair<double>());
      ASSERT_TRUE(check_well_formed(m).ok());
      if (s.reason != NoLight::kNone) continue;
      const auto wi = placement.direction(s.wi);
      const double pdf = elsewhere.pdf_li(placement.point(receiver), wi).per_sr;
      EXPECT_LE(relative_difference(pdf, s.pdf.per_sr), 1e-9);
      if (m.reason != NoLight::kNone) continue;
      const Vec3<double> back = placement.rigid.inverse().vector(m.wi);
      EXPECT_LE(relative_difference(m.value, TypeParam::value(receiver, back)), 1e-9);
    }
  }
  EXPECT_LE(relative_difference(elsewhere.power(TypeParam::scene()).lumens,
                                light.power(TypeParam::scene()).lumens),
            1e-12);
}

TYPED_TEST_P(AnyLight, ScalingByPowersOfTwoChangesNoBit) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere scene = TypeParam::scene();
  for (const int k : {-20, -1, 3, 20}) {
    const Placement placement{{}, k};
    const auto scaled_light = TypeParam::template make<float>(placement);
    RandomU random(3);
    for (const auto& receiver : TypeParam::receivers()) {
      for (int i = 0; i < 100; ++i) {
        const Vec2<float> u = random.pair();
        const auto s = light.sample_li(Vec3<float>(receiver), u);
        const auto t = scaled_light.sample_li(Vec3<float>(placement.point(receiver)), u);
        ASSERT_EQ(s.reason, t.reason);
        EXPECT_EQ(s.wi, t.wi);
        EXPECT_EQ(s.normal, t.normal);
        EXPECT_EQ(s.pdf, t.pdf);
        EXPECT_EQ(s.primitive, t.primitive);
        EXPECT_EQ(std::scalbn(s.distance, k), t.distance);
        EXPECT_EQ(s.value * std::scalbn(1.F, k * TypeParam::kValueLengthPower), t.value);
      }
    }
    const Power power = light.power(scene);
    const Power scaled_power =
        scaled_light.power({scaled(scene.center_m, k), std::scalbn(scene.radius_m, k)});
    EXPECT_EQ(power.lumens * std::scalbn(1., k * TypeParam::kPowerLengthPower),
              scaled_power.lumens);
  }
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
  const auto light = TypeParam::template make<float>({});
  for (const auto& receiver : TypeParam::receivers()) {
    const Vec3<float> r(receiver);
    const Verdict verdict = check_density_integrates(
        TypeParam::region(receiver), [&](Vec2<float> u) { return light.sample_li(r, u); },
        [&](const Vec3<double>& w) { return double{light.pdf_li(r, Vec3<float>(w)).per_sr}; });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

TYPED_TEST_P(LightWithDensity, SamplesFollowTheDensity) {
  const auto light = TypeParam::template make<float>({});
  for (const auto& receiver : TypeParam::receivers()) {
    const Vec3<float> r(receiver);
    const Verdict verdict = check_samples_follow_density(
        TypeParam::region(receiver), [&](Vec2<float> u) { return light.sample_li(r, u); },
        [&](const Vec3<double>& w) { return double{light.pdf_li(r, Vec3<float>(w)).per_sr}; });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
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
  const auto light = TypeParam::template make<float>({});
  RandomU random(4);
  for (const auto& receiver : TypeParam::receivers()) {
    const Vec3<float> r(receiver);
    const auto s = light.sample_li(r, random.pair());
    ASSERT_EQ(s.reason, NoLight::kNone);
    EXPECT_TRUE(s.delta);
    EXPECT_EQ(s.pdf.per_sr, 0);
    EXPECT_EQ(light.pdf_li(r, s.wi).per_sr, 0);
    EXPECT_EQ(light.sample_li(r, random.pair()).wi, s.wi);
  }
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

/// The mean of value / density over a grid of u: the illuminance on a surface that faces the light.
template <typename Light>
double facing_illuminance(const Light& light, const Vec3<double>& receiver,
                          const Vec3<double>& to_light) {
  constexpr int kGrid = 64;
  double sum = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Vec2<float> u{(i / kGrid + 0.5F) / kGrid, (i % kGrid + 0.5F) / kGrid};
    const auto s = light.sample_li(Vec3<float>(receiver), u);
    if (s.reason != NoLight::kNone) continue;
    const double cos = std::fmax(0, dot(to_light, Vec3<double>(s.wi)));
    sum += luminance(Rgb<double>(s.value)) * cos / (s.delta ? 1.0 : s.pdf.per_sr);
  }
  return sum / (kGrid * kGrid);
}

TYPED_TEST_P(LocalLight, FarFieldFallsOffWithTheSquareOfDistance) {
  const auto light = TypeParam::template make<float>({});
  const Vec3<double> away = TypeParam::far_direction();
  const auto scaled_illuminance = [&](double d) {
    return facing_illuminance(light, TypeParam::centre() + away * d, -away) *
           std::pow(d, -TypeParam::kFarFieldLengthPower);
  };
  // Nearer and farther parts of the light differ from its centre's 1/d^2 by up to 2 size / d.
  const double d = 4096 * TypeParam::kSize;
  const double reference = scaled_illuminance(d);
  EXPECT_EQ(reference > 0, !TypeParam::kEnclosed);
  for (const double factor : {2., 16., 256.}) {
    EXPECT_LE(relative_difference(scaled_illuminance(factor * d), reference),
              2 * TypeParam::kSize / d + TypeParam::kTolerance);
  }
}

TYPED_TEST_P(LocalLight, SampledPointsLieOnTheLight) {
  const auto light = TypeParam::template make<float>({});
  RandomU random(5);
  for (const auto& receiver : TypeParam::receivers()) {
    for (int i = 0; i < 200; ++i) {
      // Every fourth sample from the corners and edges of the unit square.
      const float edge = i % 8 == 0 ? 0.F : 1.F;
      const Vec2<float> u = i % 4 != 0 ? random.pair() : Vec2<float>{edge, random.next()};
      const auto s = light.sample_li(Vec3<float>(receiver), u);
      if (s.reason != NoLight::kNone) continue;
      const Vec3<double> p(s.point);
      const double reach = TypeParam::kSize + length(receiver);
      EXPECT_LE(TypeParam::distance_to_surface(p), TypeParam::kTolerance * reach);
      // Receiver, direction, distance and point are of one piece.
      const Vec3<double> along = receiver + Vec3<double>(s.wi) * double{s.distance};
      EXPECT_LE(distance_between(along, p), TypeParam::kTolerance * reach);
    }
  }
}

REGISTER_TYPED_TEST_SUITE_P(LocalLight, FarFieldFallsOffWithTheSquareOfDistance,
                            SampledPointsLieOnTheLight);

}  // namespace lucerna::testing

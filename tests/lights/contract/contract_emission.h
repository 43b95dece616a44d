// The contract of rays that leave lights, of bounds and of approximate power, as typed suites. They
// take the cases of contract.h, which say in addition:
//
//   // Lights whose rays start anywhere on a surface: a map of the unit square onto it that keeps
//   // area, its inverse, and the area [m2].  A ray leaves towards `w`.
//   static Vec3<double> emission_position(const Vec3<double>& w, double x, double y);
//   static Vec2<double> emission_where(const Vec3<double>& position, const Vec3<double>& w);
//   static double emission_area_m2();
//   // Optional, where a direction leaves part of the surface only: one that leaves `position`.
//   static Vec3<double> emission_direction(const Vec3<double>& position);
//   // A cone that holds all directions in which light leaves `position`.
//   static Region emission_region(const Vec3<double>& position);
//   // Optional: value of the ray; without it the case's value() one metre along the ray.
//   static Rgb<double> emitted(const Vec3<double>& position, const Vec3<double>& direction);
//   // Local lights: whether there are places that the bounds must tell to be dark.
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

#include "lights/choice/light_tree.h"
#include "tests/lights/contract/contract.h"
#include "tests/lights/contract/emission_checks.h"

namespace lucerna::testing {

/// Rays from infinitely far enter on the disk of radius 4 that touches the sphere of
/// CaseDefaults::scene() and faces their direction; polar coordinates keep area in r^2.
struct SceneDiskCase {
  static Vec3<double> emission_position(const Vec3<double>& w, double x, double y) {
    const double r = std::sqrt(x), phi = 2 * std::numbers::pi * y;
    return Frame<double>::around(w).world_from_local({r * std::cos(phi), r * std::sin(phi), -1}) *
           4.0;
  }
  static Vec2<double> emission_where(const Vec3<double>& position, const Vec3<double>& w) {
    const Vec3<double> p = Frame<double>::around(w).local_from_world(position) * 0.25;
    const double y = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
    // Off the disk's plane it lies nowhere.
    if (std::fabs(p.z + 1) > 1e-5) return {NAN, NAN};
    return {p.x * p.x + p.y * p.y, y < 0 ? y + 1 : y};
  }
  static double emission_area_m2() { return 16 * std::numbers::pi; }
  static Region emission_region(const Vec3<double>&) { return {}; }
};

/// What the case says of the value of a ray.
template <typename Case>
Rgb<double> expected_emission(const Vec3<double>& position, const Vec3<double>& direction) {
  if constexpr (requires { Case::emitted(position, direction); })
    return Case::emitted(position, direction);
  else
    return Case::value(position + direction, -direction);
}

template <typename Case>
class EmittingLight : public ::testing::Test {
 protected:
  EmittingLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("EmittingLight");
};
TYPED_TEST_SUITE_P(EmittingLight);

TYPED_TEST_P(EmittingLight, RaysAgreeWithEvaluation) {
  // In double: the value is looked up from the ray's rounded position and direction.
  const auto light = TypeParam::template make<double>({});
  const SceneSphere scene = TypeParam::scene();
  const Verdict verdict = check_emission_agrees(
      [&](Vec2<float> up, Vec2<float> ud) {
        return light.sample_le({up.x, up.y}, {ud.x, ud.y}, scene);
      },
      [&](const Vec3<double>& p, const Vec3<double>& w) { return light.pdf_le(p, w, scene); },
      expected_emission<TypeParam>, 1e-9);
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TYPED_TEST_P(EmittingLight, FloatRaysAgreeWithTheirDensities) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere scene = TypeParam::scene();
  RandomU random(11);
  for (int i = 0; i < 2000; ++i) {
    const Vec2<float> u = random.pair();
    const auto s = light.sample_le(u, random.pair(), scene);
    ASSERT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if (s.reason != NoLight::kNone) continue;
    const auto told = light.pdf_le(s.origin, s.direction, scene);
    EXPECT_LE(relative_difference(s.pdf_position.per_m2, told.position.per_m2),
              TypeParam::kTolerance);
    EXPECT_LE(relative_difference(s.pdf_direction.per_sr, told.direction.per_sr),
              TypeParam::kTolerance);
  }
}

TYPED_TEST_P(EmittingLight, MeanOfRaysIsThePower) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere scene = TypeParam::scene();
  const Power power = light.power(scene);
  const Verdict verdict = check_emission_mean(
      [&](Vec2<float> up, Vec2<float> ud) { return light.sample_le(up, ud, scene); }, power.lumens,
      1e-6 + power.error_lumens / std::fmax(luminance(power.lumens), 1e-300));
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TYPED_TEST_P(EmittingLight, ExtremeSampleValuesGiveValidRays) {
  const auto light = TypeParam::template make<float>({});
  constexpr std::array kExtremes{0.F, 1 - 0x1p-24F, 1.F};
  for (int i = 0; i < 81; ++i) {
    const auto at = [&](int n) { return kExtremes[i / n % 3]; };
    const auto s = light.sample_le({at(27), at(9)}, {at(3), at(1)}, TypeParam::scene());
    const Verdict verdict = check_well_formed(s);
    EXPECT_TRUE(verdict.ok()) << verdict.failure << " at " << i;
  }
}

TYPED_TEST_P(EmittingLight, RaysOfOtherLightsHaveNoDensity) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere scene = TypeParam::scene();
  RandomU random(12);
  const EmissionPdf<float> none{};
  for (int i = 0; i < 100; ++i) {
    const Vec2<float> u = random.pair();
    const auto s = light.sample_le(u, random.pair(), scene);
    EXPECT_EQ(light.pdf_le(s.origin + Vec3<float>{20, 30, -50}, s.direction, scene), none);
    for (const Vec3<float>& nowhere :
         {Vec3<float>{NAN, 0, 1}, {NAN, s.direction.y, s.direction.z}, {NAN, NAN, NAN}}) {
      EXPECT_EQ(light.pdf_le(nowhere, s.direction, scene), none);
      EXPECT_EQ(light.pdf_le(s.origin, nowhere, scene), none);
    }
  }
}

TYPED_TEST_P(EmittingLight, ApproximatePowerStatesItsError) {
  const auto light = TypeParam::template make<float>({});
  const Power approximate = light.power_approximate(TypeParam::scene());
  const Verdict verdict =
      check_stated_error(approximate, TypeParam::power_by_quadrature(), TypeParam::kPowerTolerance);
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
  EXPECT_GE(approximate.error_lumens, light.power(TypeParam::scene()).error_lumens);
}

REGISTER_TYPED_TEST_SUITE_P(EmittingLight, RaysAgreeWithEvaluation,
                            FloatRaysAgreeWithTheirDensities, MeanOfRaysIsThePower,
                            ExtremeSampleValuesGiveValidRays, RaysOfOtherLightsHaveNoDensity,
                            ApproximatePowerStatesItsError);

template <typename Case>
class EmittingSurface : public ::testing::Test {
 protected:
  EmittingSurface() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("EmittingSurface");
};
TYPED_TEST_SUITE_P(EmittingSurface);

TYPED_TEST_P(EmittingSurface, PositionsFollowTheDensity) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere scene = TypeParam::scene();
  RandomU random(0xe3);
  const Vec2<float> ud{0.25F, 0.625F};
  // A light that shines in proportion to a picture has one density of positions for all directions
  // that leave them; so one will do.
  const Vec3<float> w = light.sample_le({0.5F, 0.5F}, ud, scene).direction;
  const Verdict verdict = check_follows_on_square(
      [&]() -> std::optional<Vec2<double>> {
        const auto s = light.sample_le(random.pair(), ud, scene);
        if (s.reason != NoLight::kNone) return std::nullopt;
        return TypeParam::emission_where(Vec3<double>(s.origin), Vec3<double>(s.direction));
      },
      [&](double x, double y) {
        const Vec3<double> p = TypeParam::emission_position(Vec3<double>(w), x, y);
        Vec3<float> leaving = w;
        if constexpr (requires { TypeParam::emission_direction(p); })
          leaving = Vec3<float>(TypeParam::emission_direction(p));
        return light.pdf_le(Vec3<float>(p), leaving, scene).position.per_m2 *
               TypeParam::emission_area_m2();
      });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

REGISTER_TYPED_TEST_SUITE_P(EmittingSurface, PositionsFollowTheDensity);

template <typename Case>
class EmittingDirections : public ::testing::Test {
 protected:
  EmittingDirections() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("EmittingDirections");
};
TYPED_TEST_SUITE_P(EmittingDirections);

TYPED_TEST_P(EmittingDirections, DirectionsFollowTheDensity) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere scene = TypeParam::scene();
  for (const Vec2<float> up : {Vec2<float>{0.5F, 0.5F}, Vec2<float>{0.125F, 0.75F}}) {
    RandomU random(0xe4);
    const auto first = light.sample_le(up, {0.4F, 0.4F}, scene);
    const Region region = TypeParam::emission_region(Vec3<double>(first.origin));
    const Verdict verdict = check_follows_on_square(
        [&]() -> std::optional<Vec2<double>> {
          const auto s = light.sample_le(up, random.pair(), scene);
          if (s.reason != NoLight::kNone) return std::nullopt;
          return region.where(Vec3<double>(s.direction));
        },
        [&](double x, double y) {
          const Vec3<double> w = region.at(x, y);
          Vec3<float> p = first.origin;
          // From infinitely far, where a ray starts goes with its direction.
          if constexpr (std::is_base_of_v<SceneDiskCase, TypeParam>)
            p = Vec3<float>(TypeParam::emission_position(w, 0.5, 0.5));
          return light.pdf_le(p, Vec3<float>(w), scene).direction.per_sr * region.solid_angle_sr();
        });
    EXPECT_TRUE(verdict.ok()) << verdict.failure;
  }
}

REGISTER_TYPED_TEST_SUITE_P(EmittingDirections, DirectionsFollowTheDensity);

template <typename Case>
class BoundedLight : public ::testing::Test {
 protected:
  BoundedLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("BoundedLight");
};
TYPED_TEST_SUITE_P(BoundedLight);

template <typename Real, typename Case>
void expect_bounds_reach(const Placement& placement) {
  const auto light = Case::template make<Real>(placement);
  const auto bounds = light.bounds();
  ASSERT_TRUE(bounds.has_value());
  const Vec3<double> center = Vec3<double>(bounds->lower) * 0.5 + Vec3<double>(bounds->upper) * 0.5;
  const Verdict verdict = check_bounds_reach(
      *bounds, center, placement.length(Case::kSize), [&](const Vec3<Real>& p, Vec2<float> u) {
        return light.sample_li(p, {u.x, u.y}).reason == NoLight::kNone;
      });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TYPED_TEST_P(BoundedLight, BoundsReachWhereverLightArrives) {
  expect_bounds_reach<float, TypeParam>({});
  expect_bounds_reach<float, TypeParam>(moved());
  expect_bounds_reach<double, TypeParam>(moved());
}

// As in a scene: beside another light, in double.
TYPED_TEST_P(BoundedLight, ATreeChoosesItWhereverLightArrives) {
  const auto light = TypeParam::template make<double>(moved());
  const LightBounds<double> bounds = *light.bounds();
  EXPECT_LE(bounds.normals_rad, bounds.cone_rad);
  EXPECT_GE(bounds.normals_rad + std::numbers::pi / 2, bounds.two_sided ? 0 : bounds.cone_rad);
  const Vec3<double> center = bounds.lower * 0.5 + bounds.upper * 0.5;
  const double size = moved().length(TypeParam::kSize);
  const Vec3<double> aside = center + Vec3<double>{size, 3 * size, 0};
  const LightTree tree = *LightTree::create(std::vector<LightTree::Item>{
      {bounds, 1}, {{.lower = aside, .upper = aside, .cone_rad = std::numbers::pi}, 1}});
  const Verdict verdict = check_reach<double>(
      [&](const Vec3<double>& p) { return tree.probability(p, 0) > 0; }, center, size,
      [&](const Vec3<double>& p, Vec2<float> u) {
        return light.sample_li(p, {u.x, u.y}).reason == NoLight::kNone;
      });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TYPED_TEST_P(BoundedLight, BoundsHoldTheLight) {
  const auto light = TypeParam::template make<float>(moved());
  const Verdict verdict = check_bounds_hold(*light.bounds(), [&](Vec2<float> up, Vec2<float> ud) {
    return light.sample_le(up, ud, TypeParam::scene());
  });
  EXPECT_TRUE(verdict.ok()) << verdict.failure;
}

TYPED_TEST_P(BoundedLight, BoundsLeaveOutThePlacesThatAConeDoes) {
  const auto light = TypeParam::template make<float>({});
  const auto bounds = light.bounds();
  const Vec3<double> center = Vec3<double>(bounds->lower) * 0.5 + Vec3<double>(bounds->upper) * 0.5;
  RandomU random(13);
  int left_out = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec2<double> at = random.pair<double>();
    left_out +=
        bounds->reaches(Vec3<float>(center + Region{}.at(at.x, at.y) * (10 * TypeParam::kSize)))
            ? 0
            : 1;
  }
  if (TypeParam::kConfined)
    EXPECT_GT(left_out, 0);
  else
    EXPECT_EQ(left_out, 0);
}

REGISTER_TYPED_TEST_SUITE_P(BoundedLight, BoundsReachWhereverLightArrives,
                            ATreeChoosesItWhereverLightArrives, BoundsHoldTheLight,
                            BoundsLeaveOutThePlacesThatAConeDoes);

template <typename Case>
class UnboundedLight : public ::testing::Test {
 protected:
  UnboundedLight() { static_cast<void>(kTakesPart); }
  static inline const bool kTakesPart =
      takes_part<typename Case::template Light<float>>("UnboundedLight");
};
TYPED_TEST_SUITE_P(UnboundedLight);

// A light at infinity is chosen by the illuminance that its flux gives over its cross-section.
TYPED_TEST_P(UnboundedLight, HasACrossSectionAndNoBounds) {
  const auto light = TypeParam::template make<float>({});
  EXPECT_FALSE(light.bounds().has_value());
  const std::optional<double> section_m2 = light.cross_section_m2({{}, 4});
  ASSERT_TRUE(section_m2.has_value());
  EXPECT_GT(*section_m2, 0);
}

// Rays that enter by the scene's sphere have nowhere to start where that is a point; those that
// start on a portal do not ask for it.
TYPED_TEST_P(UnboundedLight, ASceneWithoutExtentGetsRaysOfPortalsOnly) {
  const auto light = TypeParam::template make<float>({});
  const SceneSphere none{{}, 0};
  RandomU random(16);
  for (int i = 0; i < 100; ++i) {
    const Vec2<float> up = random.pair(), ud = random.pair();
    const auto s = light.sample_le(up, ud, none);
    ASSERT_TRUE(check_well_formed(s).ok()) << check_well_formed(s).failure;
    if constexpr (std::is_base_of_v<SceneDiskCase, TypeParam>) {
      EXPECT_NE(s.reason, NoLight::kNone);
      EXPECT_EQ(light.pdf_le({0, 0, 0}, {0, 0, 1}, none), EmissionPdf<float>{});
    } else {
      const auto same = light.sample_le(up, ud, TypeParam::scene());
      EXPECT_EQ(s.reason, same.reason);
      EXPECT_EQ(s.origin, same.origin);
      EXPECT_EQ(s.direction, same.direction);
      if (s.reason != NoLight::kNone) continue;
      const EmissionPdf<float> told = light.pdf_le(s.origin, s.direction, none);
      EXPECT_EQ(told, light.pdf_le(s.origin, s.direction, TypeParam::scene()));
      EXPECT_GT(told.position.per_m2, 0);
    }
  }
}

REGISTER_TYPED_TEST_SUITE_P(UnboundedLight, HasACrossSectionAndNoBounds,
                            ASceneWithoutExtentGetsRaysOfPortalsOnly);

}  // namespace lucerna::testing

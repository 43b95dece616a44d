// The contract suites on whole and cut spheres.  The expected answers come from solid geometry, not
// from the code of the shape.
#include <cmath>
#include <vector>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/area_cases.h"
#include "tests/lights/contract/contract_emission.h"
#include "tests/lights/contract/contract_irradiance.h"

namespace lucerna::testing {
namespace {

/// Whether the ray along `wi` passes within `radius` of the origin, with the slack of a float.
bool meets_ball(const Vec3& r, const Vec3& wi, double radius) {
  return length(cross(r, wi)) < radius * (1 + 1e-5);
}

struct SphereCase : AreaCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create(
        {kLevel}, *Sphere::create({.radius_m = 0.75, .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{2, 1, 2}, {0, 0, -1.75}, {0, 80, 60}}; }
  static Region region(const Vec3& r) {
    return {normalized(-r), 1.05 * std::asin(0.75 / length(r))};
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    return meets_ball(r, wi, 0.75) ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) { return std::fabs(length(p) - 0.75); }
  /// Zones of equal height on a sphere have equal areas.  (Archimedes)
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const double z = 2 * x - 1, r = std::sqrt(1 - z * z);
    return Vec3{r * std::cos(2 * kPi * y), r * std::sin(2 * kPi * y), z} * 0.75;
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.z / 0.75 + 1) / 2, share_of_turn(p, 2 * kPi)};
  }
  static double emission_area_m2() { return 4 * kPi * 0.75 * 0.75; }
  static Vec3 emission_direction(const Vec3& p) { return normalized(p); }
  static Region emission_region(const Vec3& p) { return hemisphere(p); }
  static constexpr bool kConfined = false;
  static Rgb power_by_quadrature() { return lambertian_power(4 * kPi * 0.75 * 0.75); }
};

/// A sphere that emits inwards, seen from within: no light leaves it.
struct InwardSphereCase : SphereCase {
  static constexpr bool kEnclosed = true;
  static Light make(const Placement& at) {
    return *Light::create({kLevel}, *Sphere::create({.radius_m = 0.75,
                                                     .reverse_orientation = true,
                                                     .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {0.25, -0.25, 0.375}}; }
  static Vec3 emission_direction(const Vec3& p) { return normalized(-p); }
  static Region emission_region(const Vec3& p) { return hemisphere(-p); }
  static Region region(const Vec3&) { return {}; }
};

/// The cap z > 0.75 of a sphere of radius 1 that emits outwards.  It is seen without its
/// silhouette.  There the density by area has a pole, which no quadrature on a grid resolves.
struct CapCase : AreaCase {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create({kLevel}, *Sphere::create({.radius_m = 1,
                                                     .z_min_m = 0.75,
                                                     .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{0, 0.5, 3}, {1, 0, 3}}; }
  static Rgb value(const Vec3& r, const Vec3& wi) { return meets_ball(r, wi, 1) ? kLevel : Rgb{}; }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(length(p) - 1), 0.75 - p.z);
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    const double z = 0.75 + 0.25 * x, r = std::sqrt(1 - z * z);
    return {r * std::cos(2 * kPi * y), r * std::sin(2 * kPi * y), z};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.z - 0.75) / 0.25, share_of_turn(p, 2 * kPi)};
  }
  static double emission_area_m2() { return 2 * kPi * 0.25; }
  static Vec3 emission_direction(const Vec3& p) { return normalized(p); }
  static Region emission_region(const Vec3& p) { return hemisphere(p); }
  static Rgb power_by_quadrature() { return lambertian_power(2 * kPi * 0.25); }
};

using SphereCases = ::testing::Types<SphereCase, InwardSphereCase, CapCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, AnyLight, SphereCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, LightWithDensity, SphereCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, LocalLight, SphereCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, EmittingLight, SphereCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, EmittingDirections, SphereCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, BoundedLight, SphereCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, EmittingSurface, SphereCases);

using SpheresInClosedForm = ::testing::Types<SphereCase, InwardSphereCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Sphere, LightWithIrradiance, SpheresInClosedForm);

TEST(LightWithIrradiance, OnlyWholeSpheresHaveAClosedForm) {
  EXPECT_TRUE(has_irradiance<SphereCase>());
  EXPECT_FALSE(has_irradiance<CapCase>());
}

TEST(LightWithIrradiance, ASphereDoesNotHideItself) {
  EXPECT_FALSE(SphereCase::make({}).hides_itself());
}

}  // namespace
}  // namespace lucerna::testing

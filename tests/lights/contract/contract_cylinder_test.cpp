// The contract suites on cylinder lights.  The expected answers come from the quadratic equation.
#include <cmath>
#include <optional>
#include <utility>

#include "lights/models/all_lights.h"
#include "lights/shapes/all_shapes.h"
#include "tests/lights/contract/area_cases.h"
#include "tests/lights/contract/contract_emission.h"

namespace lucerna::testing {
namespace {

constexpr double kRadius = 0.5, kHalfHeight = 0.75;

/// Both t at which the line from `r` along `wi` meets the infinite cylinder, with the slack of a
/// float.
std::optional<std::pair<double, double>> roots(const Vec3& r, const Vec3& wi) {
  const double a = wi.x * wi.x + wi.y * wi.y, b = r.x * wi.x + r.y * wi.y;
  const double c = r.x * r.x + r.y * r.y - kRadius * kRadius * (1 + 1e-5);
  if (!(a > 0) || b * b < a * c) return std::nullopt;
  const double root = std::sqrt(b * b - a * c);
  return std::pair{(-b - root) / a, (-b + root) / a};
}

/// A quarter of a tube that emits outwards, seen from places that all of it faces.  At a silhouette
/// the density by area has a pole, which no quadrature on a grid resolves.
struct QuarterTubeCase : CaseDefaults {
  using Light = AreaLight;
  static Light make(const Placement& at) {
    return *Light::create({kLevel},
                          *Cylinder::create({.radius_m = kRadius,
                                             .z_min_m = -kHalfHeight,
                                             .z_max_m = kHalfHeight,
                                             .phi_max_rad = kPi / 2,
                                             .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{2, 1.5, 0.25}, {1, 2, -2}}; }
  static Region region(const Vec3& receiver) {
    return {normalized(-receiver), 1.05 * std::asin(0.91 / length(receiver))};
  }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto t = roots(r, wi);
    if (!t) return {};
    const Vec3 p = r + wi * t->first;
    const bool on = p.x > -1e-5 && p.y > -1e-5 && std::fabs(p.z) < kHalfHeight + 1e-5;
    return on ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    const double off = std::fabs(std::hypot(p.x, p.y) - kRadius);
    return std::fmax(std::fmax(off, std::fabs(p.z) - kHalfHeight), std::fmax(-p.x, -p.y));
  }
  static Rgb emitted(const Vec3&, const Vec3&) { return kLevel; }
  static constexpr double kSweep = kPi / 2;
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return {kRadius * std::cos(kSweep * y), kRadius * std::sin(kSweep * y),
            kHalfHeight * (2 * x - 1)};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    return {(p.z / kHalfHeight + 1) / 2, std::atan2(p.y, p.x) / kSweep};
  }
  static double emission_area_m2() { return kSweep * kRadius * 2 * kHalfHeight; }
  static Region emission_region(const Vec3& p) { return hemisphere({p.x, p.y, 0}); }
  static constexpr bool kConfined = true;
  static Vec3 far_direction() { return normalized(Vec3{1, 1, 0.5}); }
  /// The area is a quarter of 2 pi r h.
  static Rgb power_by_quadrature() { return lambertian_power(kPi / 2 * kRadius * 2 * kHalfHeight); }
};

/// A whole tube that emits inwards.
struct InwardTubeCase : QuarterTubeCase {
  static Light make(const Placement& at) {
    return *Light::create({kLevel},
                          *Cylinder::create({.radius_m = kRadius,
                                             .z_min_m = -kHalfHeight,
                                             .z_max_m = kHalfHeight,
                                             .reverse_orientation = true,
                                             .world_from_object = at.world_from_light()}));
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {0.125, -0.25, 0.375}}; }
  /// All directions, about a tilted axis: about the tube's own, the rims would run along the cells
  /// of the quadrature.
  static Region region(const Vec3&) { return {normalized(Vec3{1, 2, 3}), kPi}; }
  static Rgb value(const Vec3& r, const Vec3& wi) {
    const auto t = roots(r, wi);
    const bool on = t && std::fabs(r.z + wi.z * t->second) < kHalfHeight + 1e-5;
    return on ? kLevel : Rgb{};
  }
  static double distance_to_surface(const Vec3& p) {
    return std::fmax(std::fabs(std::hypot(p.x, p.y) - kRadius), std::fabs(p.z) - kHalfHeight);
  }
  static Vec3 emission_position(const Vec3&, double x, double y) {
    return {kRadius * std::cos(2 * kPi * y), kRadius * std::sin(2 * kPi * y),
            kHalfHeight * (2 * x - 1)};
  }
  static Vec2 emission_where(const Vec3& p, const Vec3&) {
    const double y = std::atan2(p.y, p.x) / (2 * kPi);
    return {(p.z / kHalfHeight + 1) / 2, y < 0 ? y + 1 : y};
  }
  static double emission_area_m2() { return 4 * QuarterTubeCase::emission_area_m2(); }
  static Vec3 emission_direction(const Vec3& p) { return emission_region(p).axis; }
  static Region emission_region(const Vec3& p) { return hemisphere({-p.x, -p.y, 0}); }
  static constexpr bool kConfined = false;
  static Rgb power_by_quadrature() { return QuarterTubeCase::power_by_quadrature() * 4.0; }
};

using CylinderCases = ::testing::Types<QuarterTubeCase, InwardTubeCase>;
INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, AnyLight, CylinderCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, LightWithDensity, CylinderCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, LocalLight, CylinderCases);

INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, EmittingLight, CylinderCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, EmittingDirections, CylinderCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, BoundedLight, CylinderCases);
INSTANTIATE_TYPED_TEST_SUITE_P(Cylinder, EmittingSurface, CylinderCases);

}  // namespace
}  // namespace lucerna::testing

// The lights without a surface, as cases of the contract suites.  The expected answers do not use
// the code of the lights.
#pragma once

#include "lights/maths/vec.h"
#include "lights/models/distant_light.h"
#include "lights/models/infinite_light.h"
#include "lights/models/point_light.h"
#include "lights/models/spot_light.h"
#include "tests/lights/contract/contract.h"

namespace lucerna::testing {

inline const Rgb kDeltaLevel{3, 5, 7};

/// Composite Simpson's rule on 2 n intervals.
template <typename F>
inline double simpson(double a, double b, int n, F&& f) {
  const double h = (b - a) / (2 * n);
  double sum = f(a) + f(b);
  for (int i = 1; i < 2 * n; ++i) sum += f(a + i * h) * (i % 2 == 1 ? 4 : 2);
  return sum * h / 3;
}

/// 0 where `wi` points from `receiver` to `target`, NaN elsewhere: a wrong direction makes the
/// expected value NaN.
inline double zero_if_towards(const Vec3& target, const Vec3& receiver, const Vec3& wi) {
  const Vec3 d = target - receiver;
  const bool towards = length(cross(d, wi)) < 1e-6 * length(d) && dot(d, wi) > 0;
  return towards ? 0 : NAN;
}

struct LocalDeltaCase : CaseDefaults {
  static constexpr int kValueLengthPower = -2;
  static constexpr int kPowerLengthPower = 0;
  static Vec3 position() { return {0.25, -0.5, 1}; }
  // Distances count from the point itself, so that its 1/d^2 is also exact in the far field.  Then
  // directions to the point do not change, however its intensity depends on them.
  static Vec3 centre() { return position(); }
  static double distance_to_surface(const Vec3& p) { return length(p - position()); }
};

struct PointCase : LocalDeltaCase {
  using Light = PointLight;
  static PointLight make(const Placement& placement) {
    return *PointLight::create(
        {.position_m = placement.point(position()), .intensity_cd = kDeltaLevel});
  }
  static std::vector<Vec3> receivers() {
    return {{0, 0, 0}, {1, 2, 3}, {-100, 50.5, 3}, {0.25, -0.5, 1 + 0x1p-10}};
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = position() - receiver;
    return kDeltaLevel * (1 / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  /// The flux through a cube of side 2 about the light: six times that through one face.
  static Rgb power_by_quadrature() {
    return kDeltaLevel * (6 * simpson(-1, 1, 100, [](double x) {
                            return simpson(-1, 1, 100, [x](double y) {
                              return std::pow(1 + x * x + y * y, -1.5);
                            });
                          }));
  }
};

/// Angles as a spot's edge.  The falloff is from pbrt-v4's description: smoothstep in the cosine.
template <int kConeMilliradians, int kStartMilliradians,
          SpotProfile kProfile = SpotProfile::kSmoothstep>
struct SpotCase : LocalDeltaCase {
  static constexpr double kCone = kConeMilliradians * 1e-3, kStart = kStartMilliradians * 1e-3;
  using Light = SpotLight;
  static Vec3 axis() { return {0, 0, -1}; }
  static Vec3 far_direction() { return axis(); }
  static SpotLight make(const Placement& placement) {
    return *SpotLight::create({.position_m = placement.point(position()),
                               .axis = placement.direction(axis()) * 2.0,
                               .intensity_cd = kDeltaLevel,
                               .cone_half_angle_rad = kCone,
                               .falloff_start_rad = kStart,
                               .profile = kProfile});
  }
  static std::vector<Vec3> receivers() {
    return {{0.25, -0.5, -2}, {0.75, -0.25, -1}, {1, -0.5, -0.5}, {0, 0.5, -100}};
  }
  static double falloff(double theta) {
    if (theta <= kStart) return 1;
    if (theta >= kCone) return 0;
    const double t = (std::cos(theta) - std::cos(kCone)) / (std::cos(kStart) - std::cos(kCone));
    return kProfile == SpotProfile::kQuartic     ? std::pow(t, 4)
           : kProfile == SpotProfile::kQuadratic ? t * t
                                                 : 3 * t * t - 2 * t * t * t;
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = position() - receiver;
    const double theta = std::atan2(length(cross(-d, axis())), dot(-d, axis()));
    return kDeltaLevel * (falloff(theta) / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  static Rgb power_by_quadrature() {
    const auto ring = [](double theta) { return falloff(theta) * 2 * kPi * std::sin(theta); };
    // Not across the hard edge itself, where Simpson's rule would be wrong.
    const double edge = kStart < kCone ? simpson(kStart, kCone, 500, ring) : 0;
    return kDeltaLevel * (simpson(0, kStart, 500, ring) + edge);
  }
};
using SoftSpotCase = SpotCase<700, 300>;
using HardSpotCase = SpotCase<600, 600>;
using QuadraticSpotCase = SpotCase<800, 200, SpotProfile::kQuadratic>;
using QuarticSpotCase = SpotCase<900, 400, SpotProfile::kQuartic>;
using WideSpotCase = SpotCase<3000, 1800>;

/// A spot whose transform scales by 1, 2 and 1/2 along x, y and z.  Its cone is round in its own
/// space, where a direction has these factors taken out.
struct DeformedSpotCase : SoftSpotCase {
  static constexpr double kPowerTolerance = 1e-5;  // of the grid of directions
  static Vec3 own(const Vec3& w) { return {w.x, w.y / 2, w.z * 2}; }
  static SpotLight make(const Placement& placement) {
    const Frame axes{placement.direction({1, 0, 0}), placement.direction({0, 2, 0}),
                     placement.direction({0, 0, 0.5})};
    return *SpotLight::create({.position_m = placement.point(position()),
                               .axis = placement.direction(axis()) * 2.0,
                               .intensity_cd = kDeltaLevel,
                               .cone_half_angle_rad = kCone,
                               .falloff_start_rad = kStart,
                               .own_space = std::make_shared<const Frame>(axes)});
  }
  static double share(const Vec3& w) {
    const Vec3 v = own(w);
    return falloff(std::atan2(length(cross(v, axis())), dot(v, axis())));
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = position() - receiver;
    return kDeltaLevel * (share(-d) / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  static Rgb power_by_quadrature() {
    return integrate(Region{axis(), kPi / 2}, 2000,
                     [](const Vec3& w) { return kDeltaLevel * share(w); });
  }
};

struct DistantCase : CaseDefaults {
  using Light = DistantLight;
  static Vec3 to_light() { return {1, 2, 2}; }
  static DistantLight make(const Placement& placement) {
    return *DistantLight::create(
        {.to_light = placement.direction(to_light()), .illuminance_lx = kDeltaLevel});
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {1e6, -3, 0x1p-40}}; }
  static Rgb value(const Vec3&, const Vec3& wi) {
    return kDeltaLevel * (1 + zero_if_towards(to_light(), {}, wi));
  }
  /// Through the disk that the scene's sphere of radius 4 covers, ring by ring.
  static Rgb power_by_quadrature() {
    return kDeltaLevel * simpson(0, 4, 10, [](double r) { return 2 * kPi * r; });
  }
};

struct InfiniteCase : CaseDefaults {
  using Light = UniformInfiniteLight;
  static UniformInfiniteLight make(const Placement&) {
    return *UniformInfiniteLight::create({.radiance_cd_m2 = kDeltaLevel});
  }
  static std::vector<Vec3> receivers() { return {{0, 0, 0}, {1e6, -3, 5}}; }
  static Region region(const Vec3&) { return {}; }
  static Rgb value(const Vec3&, const Vec3&) { return kDeltaLevel; }
  /// The flux into the scene's sphere of radius 4: at each point of its surface, the radiance of a
  /// hemisphere, weighted with the cosine.
  static Rgb power_by_quadrature() {
    const Vec3 n{0, 0, 1};
    const double area = 4 * kPi * 4 * 4;
    return integrate(Region{n, kPi / 2}, 400,
                     [&](const Vec3& w) { return kDeltaLevel * (area * dot(w, n)); });
  }
};

}  // namespace lucerna::testing

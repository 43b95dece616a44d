// A light with the answers that are expected of it, computed without the light's code.  The
// contract runs every check on each case.  Which suites apply follows from the light.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lights/models/light.h"
#include "tests/lights/contract/contract_checks.h"

namespace lucerna::testing {

/// A region of directions on the unit square: Region, or the case's own.
struct CaseRegion {
  std::function<Vec3(double, double)> at;
  std::function<Vec2(const Vec3&)> where;
  std::function<double(double, double)> element_sr;

  CaseRegion() : CaseRegion(Region{}) {}
  template <typename R>
  CaseRegion(const R& r)  // NOLINT(google-explicit-constructor)
      : at([r](double x, double y) { return r.at(x, y); }),
        where([r](const Vec3& w) { return r.where(w); }),
        element_sr([r](double x, double y) { return testing::element_sr(r, x, y); }) {}
};

/// All but the first two members are in the space of the light without a placement.
struct LightCase {
  std::string name{};
  /// Builds the light with all its lengths times 2^exponent, then moved.
  std::function<std::unique_ptr<const Light>(const Placement&)> make{};
  /// The receiver at `p`; without it a point.
  std::function<Receiver(const Vec3& p, const Placement&)> receiver_at{};
  /// Whether another case has the same light for other receivers.
  bool receivers_only = false;

  /// Floats hold them exactly.
  std::vector<Vec3> receivers{};
  /// More for the irradiance in closed form.
  std::vector<Vec3> near_receivers{};
  /// What arrives at `receiver` along the unit vector `wi`: radiance; for a delta light, the
  /// illuminance on a surface that faces it.  Empty: only the densities are checked.
  std::function<Rgb(const Vec3& receiver, const Vec3& wi)> value{};
  /// Lights with a density: directions that hold all of the light.
  std::function<CaseRegion(const Vec3& receiver)> region{};
  /// Lights with bounds: the distance of `p` from the light's surface [m].
  std::function<double(const Vec3& p)> distance_to_surface{};
  /// By the test's own quadrature.
  std::function<Rgb()> power_lm{};

  /// Rays that start anywhere on a surface: a map of the unit square onto it that keeps area, its
  /// inverse, and the area.  A ray leaves towards `w`.
  std::function<Vec3(const Vec3& w, double x, double y)> emission_position{};
  std::function<Vec2(const Vec3& position, const Vec3& w)> emission_where{};
  double emission_area_m2 = 0;
  /// Where a direction leaves only part of the surface: one that leaves `position`.
  std::function<Vec3(const Vec3& position)> emission_direction{};
  /// Rays that leave in many directions: a cone that holds all of them.
  std::function<Region(const Vec3& position)> emission_region{};
  /// The value of a ray; without it the case's value one metre along the ray.
  std::function<Rgb(const Vec3& position, const Vec3& w)> emitted{};
  /// Rays from infinitely far enter by the disk of `scene`.
  bool enters_by_scene_disk = false;

  /// A value is proportional to length to this power: -2 for lights with an intensity, 0 for lights
  /// with a radiance.
  int value_length_power = 0;
  /// Power too: 2 for radiance or illuminance, 0 for intensity.
  int power_length_power = 2;
  /// Relative error of a reported density against an evaluated one, and of a value.
  double tolerance = 1e-12;
  double power_tolerance = 1e-6;
  /// Of the radiance at a point against that of the light created there; 0 where it is uniform.
  double moved_tolerance = 0;
  /// The size of the light [m].  The far field begins at a multiple of it.
  double size = 1;
  Vec3 centre{};
  /// In the far field, illuminance is proportional to distance to this power: 0 for parallel rays.
  int far_field_length_power = -2;
  /// The direction of the far field from the light's centre, a unit vector.
  Vec3 far_direction{0, 0, 1};
  /// Whether no light leaves the shape: then there is no far field.
  bool enclosed = false;
  /// Whether the bounds must report some places as dark.
  bool confined = false;

  Receiver receiver(const Vec3& p, const Placement& at = {}) const {
    return receiver_at ? receiver_at(p, at) : Receiver(p);
  }
};

inline const SceneSphere kScene{{}, 4};

inline Placement moved() {
  return {Transform::translate({3, -2, 5}) * *Transform::rotate(2, {1, -3, 2}), 0};
}

/// Composite Simpson's rule on 2 n intervals.
template <typename F>
double simpson(double a, double b, int n, F&& f) {
  const double h = (b - a) / (2 * n);
  double sum = f(a) + f(b);
  for (int i = 1; i < 2 * n; ++i) sum += f(a + i * h) * (i % 2 == 1 ? 4 : 2);
  return sum * h / 3;
}

/// A case whose light has the parameters `params(placement)`.
template <typename L, typename Params>
LightCase light_case(std::string name, Params params) {
  LightCase c;
  c.name = std::move(name);
  c.make = [params](const Placement& at) {
    return std::make_unique<const L>(*L::create(params(at)));
  };
  return c;
}

/// The table: each shape with each emission that it can have, and the lights without a surface.
void add_area_lights(std::vector<LightCase>& cases);
void add_delta_lights(std::vector<LightCase>& cases);
void add_lights_beyond(std::vector<LightCase>& cases);
const std::vector<LightCase>& all_cases();

}  // namespace lucerna::testing

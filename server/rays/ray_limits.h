// The space in which Embree is asked: scaled by a power of two so that what it holds is about as
// large as 1, whatever its size in metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "lights/maths/transform.h"
#include "server/rays/ray.h"

namespace lucerna {

/// The power of two by which coordinates up to `reach_m` are divided, to be at most 2.
double unit_for(double reach_m);

/// A space that Embree holds, scene's or object's.
struct RaySpace {
  explicit RaySpace(double reach_m = 0)
      : unit_m(unit_for(reach_m)), per_unit(1 / unit_m), reach_m(reach_m) {}

  double unit_m;    ///< what its coordinates are multiples of, a power of two
  double per_unit;  ///< 1 / unit_m, exactly
  double reach_m;   ///< the largest coordinate of what can be hit
  /// Of a direction's largest component.  Embree takes a denominator below 1e-18 for 1e-18, its
  /// sign forgotten; it is the area of a triangle times the length of the direction times their
  /// cosine. So directions are long, by a power of two, but not so long that instances make them
  /// leave floats; no bit of an answer but its exponent shows it.
  int direction_exponent = 20;
};

/// A ray in such a space.
struct UnitRay {
  Vec3<float> origin, direction;
  float t_min, t_max;
  /// t of the ray that was asked about is that of this one times `units`, plus `start`.
  double units, start;
};

/// Where a ray enters a sphere about zero that holds all that can be hit.
struct Entry {
  Vec3<double> origin_m;
  double t;
};

/// Nothing where it passes by.  The origin is outside of twice the reach.
std::optional<Entry> entry_from_afar(const Vec3<double>& origin_m, const Vec3<double>& direction,
                                     double reach_m);

/// Nothing where the ray is none, or where it passes by all that can be hit.  A ray from far off
/// begins near that, at a point found in double: floats tell points apart only as far as 2^-24 of
/// their distance from a ray's origin.
inline std::optional<UnitRay> unit_ray(Vec3<double> origin_m, const Vec3<double>& direction,
                                       double t_min, double t_max, const RaySpace& space) {
  // Inline, as every ray pays for it.
  constexpr double kFar = 16;  // beyond so many times the reach rays are moved
  const double longest = max_abs(direction);
  if (!is_finite(origin_m) || !is_finite(direction) || !(longest > 0) || std::isnan(t_min) ||
      std::isnan(t_max))
    return std::nullopt;
  double start = 0;
  if (max_abs(origin_m) > kFar * space.reach_m) [[unlikely]] {
    const auto entry = entry_from_afar(origin_m, direction, space.reach_m);
    if (!entry) return std::nullopt;
    origin_m = entry->origin_m, start = entry->t;
    if (start > 0) t_min = std::max(t_min, start);
  }
  const int exponent = space.direction_exponent - exponent_of(longest);
  // Powers of two: products with them are what quotients would be, at a fraction of the time.
  const double per_t = scaled(space.per_unit, -exponent);
  const UnitRay ray{Vec3<float>(origin_m * space.per_unit),
                    Vec3<float>(scaled(direction, exponent)),
                    static_cast<float>((t_min - start) * per_t),
                    static_cast<float>((t_max - start) * per_t),
                    scaled(space.unit_m, exponent),
                    start};
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

/// By how much a ray's coordinates may grow on the way into the object's space, at least 1;
/// infinite where they would not fit.
double magnification(const Transform& scene_from_object);

}  // namespace lucerna

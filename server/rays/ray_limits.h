// The space of Embree's rays.  It is scaled by a power of two so that the geometry has the same
// size for any size in metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "lights/maths/transform.h"
#include "server/rays/ray.h"

namespace lucerna {

/// Coordinates in the space of Embree are below 2^(kReachExponent + 1).  Embree multiplies the two
/// edges of a triangle and its distance from a ray.  A ray may start 1e-9 m above a sheet of 1 mm.
/// If a ground of 1e8 m had size 1, this product would be 1e-39, which floats do not hold.
inline constexpr int kReachExponent = 8;

/// The power of two that divides coordinates up to `reach_m` so that they have this size.
double unit_for(double reach_m);

/// A space of Embree: the scene's or an object's.
struct RaySpace {
  explicit RaySpace(double reach_m = 0)
      : unit_m(unit_for(reach_m)), per_unit(1 / unit_m), reach_m(reach_m) {}

  double unit_m;    ///< the unit of its coordinates, a power of two
  double per_unit;  ///< 1 / unit_m, exactly
  double reach_m;   ///< largest coordinate of the geometry
  /// Exponent of a direction's largest component.  Embree replaces a denominator below 1e-18 by
  /// 1e-18 and loses its sign.  The denominator is the area of a triangle times the length of the
  /// direction times their cosine.  So directions are scaled up by a power of two.  They stay short
  /// enough to fit floats in each instance's space.  The factor changes only the exponent of t.
  int direction_exponent = 20;
};

/// A ray in the space of Embree.
struct UnitRay {
  Vec3f origin, direction;
  float t_min, t_max;
  /// t of the original ray is t of this ray times `units`, plus `start`.
  double units, start;
};

/// The point where a ray enters a sphere about zero that contains the geometry.
struct Entry {
  Vec3 origin_m;
  double t;
};

/// Nothing if the ray misses the sphere.  The origin must be farther away than twice the reach.
std::optional<Entry> entry_from_afar(const Vec3& origin_m, const Vec3& direction, double reach_m);

/// Nothing for an invalid ray, and for a ray that misses all geometry.  A ray from far away starts
/// near the geometry, at a point computed in double.  Floats resolve points only to 2^-24 of their
/// distance from a ray's origin.
inline std::optional<UnitRay> unit_ray(Vec3 origin_m, const Vec3& direction, double t_min,
                                       double t_max, const RaySpace& space) {
  // Inline, because every ray needs it.
  constexpr double kFar =
      16;  // farther than this multiple of the reach, the start of a ray is moved
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
  // Multiplying by a power of two has the same result as dividing, in a fraction of the time.
  const double per_t = scaled(space.per_unit, -exponent);
  const UnitRay ray{Vec3f(origin_m * space.per_unit),
                    Vec3f(scaled(direction, exponent)),
                    static_cast<float>((t_min - start) * per_t),
                    static_cast<float>((t_max - start) * per_t),
                    scaled(space.unit_m, exponent),
                    start};
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

/// The largest growth of a ray's coordinates when it is converted to the object's space, at least
/// 1.  Infinite if they would not fit.
double magnification(const Transform& scene_from_object);

}  // namespace lucerna

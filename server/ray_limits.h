// The space in which Embree is asked: scaled by a power of two so that what it holds is about as
// large as 1, whatever its size in metres.
#pragma once

#include <optional>

#include "lights/transform.h"
#include "server/ray.h"

namespace lucerna {

/// A space that Embree holds, scene's or object's.
struct RaySpace {
  double unit_m = 1;   ///< what its coordinates are multiples of, a power of two
  double reach_m = 0;  ///< the largest coordinate of what can be hit
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

/// Nothing where the ray is none, or where it passes by all that can be hit.  A ray from far off
/// begins near that, at a point found in double: floats tell points apart only as far as 2^-24 of
/// their distance from a ray's origin.
std::optional<UnitRay> unit_ray(const Vec3<double>& origin_m, const Vec3<double>& direction,
                                double t_min, double t_max, const RaySpace& space);

/// The power of two by which coordinates up to `reach_m` are divided, to be at most 2.
double unit_for(double reach_m);

/// By how much a ray's coordinates may grow on the way into the object's space, at least 1;
/// infinite where they would not fit.
double magnification(const Transform& scene_from_object);

}  // namespace lucerna

// Which rays Embree can be asked about, and how long to make their directions.
#pragma once

#include "lights/transform.h"

namespace lucerna {

/// Embree's own assertions end the process at coordinates of 1.8e18, in the scene's space or an
/// instanced object's.
struct RayLimits {
  float max_origin = 0x1p58f;  ///< coordinates of origins lie below [m]
  int direction_exponent = 0;  ///< of the longest component, as Embree gets it
};

/// Embree takes a denominator below 1e-18 for 1e-18, its sign forgotten; it is the area of a
/// triangle times the length of the direction times their cosine.  In scenes of micrometres grazing
/// rays then hit the surface that they leave.  So directions are given a length, a power of two,
/// that makes up for the scene's scale and leaves room at both ends; no bit of an answer but its
/// exponent shows it.
///
/// `extent`: of the scene's bounds [m]; `magnified`: by how much instances may enlarge a ray as
/// they take it into their object's space.
RayLimits limits_for(float extent, double magnified);

/// By how much a ray's coordinates may grow on the way into the object's space, at least 1;
/// infinite where they would not fit.
double magnification(const Transform& scene_from_object);

}  // namespace lucerna

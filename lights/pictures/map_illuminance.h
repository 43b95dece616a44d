// What a picture around the sphere of directions sends onto a plane.
#pragma once

#include "lights/pictures/sphere_map.h"

namespace lucerna {

struct MapIlluminance {
  Rgb<double> lx;     ///< integral of the map times the cosine, over the directions above the plane
  double error_lx{};  ///< bound on the error of its luminance
  Rgb<double> without_cosine;  ///< the integral of the map over those directions
};

/// For a texel of value `radiance` [cd/m2] and the plane whose upper side faces `n`, a unit vector
/// in the map's own axes.
///
/// By the midpoints of cells, on each of which the map is constant (nearest) or bilinear, at least
/// 2^18 of them where the picture is no strip.  The bound adds up, cell by cell, the second
/// derivatives of the direction over the picture, and the first ones where the cell lies across a
/// fold of the mapping or across the plane.
MapIlluminance illuminance_of(const SphereMap& map, const Rgb<double>& radiance,
                              const Vec3<double>& n);

}  // namespace lucerna

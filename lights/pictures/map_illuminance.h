// The illuminance of a picture around the sphere of directions on a plane.
#pragma once

#include "lights/pictures/sphere_map.h"

namespace lucerna {

struct MapIlluminance {
  Rgb lx;             ///< integral of the map times the cosine, over the directions above the plane
  double error_lx{};  ///< bound on the error of its luminance
  Rgb without_cosine;  ///< the integral of the map over those directions
};

/// For a texel of value `radiance` [cd/m2] and the plane whose upper side faces `n`, a unit vector
/// in the map's own axes.
///
/// Computed from the midpoints of cells on which the map is constant (nearest) or bilinear.  There
/// are at least 2^18 cells unless the picture is a strip.  The error bound is a sum over cells of
/// second derivatives of the direction over the picture.  Cells that cross the plane or a fold of
/// the mapping use first derivatives.
MapIlluminance illuminance_of(const SphereMap& map, const Rgb& radiance, const Vec3& n);

}  // namespace lucerna

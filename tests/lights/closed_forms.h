// Irradiance from polygons of radiance 1 in closed form, derived here by hand.  Project the visible
// part of the light onto the unit sphere about the receiver, then onto the receiver's plane.
// Irradiance is the area of that projection (Nusselt's analogue): a contour integral, 1/2 of
// (x dy - y dx) along its edge.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna::testing {

/// The part of a polygon on the side of `n` of the plane through the origin.  Clips corner by
/// corner (Sutherland and Hodgman).
inline std::vector<Vec3> above_horizon(const std::vector<Vec3>& corners, const Vec3& n) {
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[(i + 1) % corners.size()];
    const double ha = dot(a, n), hb = dot(b, n);
    if (ha >= 0) kept.push_back(a);
    if ((ha >= 0) != (hb >= 0)) kept.push_back(a + (b - a) * (ha / (ha - hb)));
  }
  return kept;
}

/// The irradiance from a flat polygon that emits to the side of the receiver.  The part below the
/// horizon is clipped.  Along an edge the unit vector w moves in the plane of edge and receiver.
/// So w x dw is that plane's normal m times the angle that w moves.  The area is half the sum of
/// the edges' angles times m.n.  (Lambert, Photometria, 1760)
inline double polygon_irradiance(std::vector<Vec3> corners, const Vec3& receiver, const Vec3& n) {
  for (Vec3& corner : corners) corner = corner - receiver;
  corners = above_horizon(corners, n);
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[(i + 1) % corners.size()];
    const Vec3 m = cross(a, b);
    sum += std::atan2(length(m), dot(a, b)) * dot(normalized(m), n);
  }
  return std::fabs(sum) / 2;
}

}  // namespace lucerna::testing

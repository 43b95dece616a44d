// The triple product of three differences.  It is exact even if they nearly lie in one plane.  It
// gives the height of a receiver above a flat light, also close to the light's plane.
#pragma once

#include "lights/maths/vec.h"

namespace lucerna {

/// dot(a - p, cross(e, f)): six times the volume of the tetrahedron of p and the triangle a, a + e,
/// a + f. Negative where p is on the side that cross(e, f) points to. The relative error is within
/// 1e-11, for results down to 1e-28 of the product of the three lengths.  If the plain product is
/// less exact, the difference and the products use two doubles each.  [Dekker71; Shewchuk97]
double triple_product(const Vec3& p, const Vec3& a, const Vec3& e, const Vec3& f);

/// The same with e = b - a and f = c - a, whose roundings would tilt the plane: they use two
/// doubles too.  0 where p is one of the corners.
double triple_product_of_corners(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// How far `p` is above the plane of the triangle a, b, c, on the side of cross(b - a, c - a).  As
/// exact as the triple product, for lengths of 1e-150 to 1e150.  0 within the plane, and for a
/// triangle without area.
double height_over(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// The same over the plane of the edges e and f from a.
double height_over_edges(const Vec3& p, const Vec3& a, const Vec3& e, const Vec3& f);

}  // namespace lucerna

// The triple product of three differences, right to its last digits however nearly they lie in one
// plane: how far a receiver is above a flat light whose plane it is all but in.
#pragma once

#include "lights/maths/vec.h"

namespace lucerna {

/// dot(a - p, cross(e, f)): six times the volume of the tetrahedron of p and the triangle a, a + e,
/// a + f; negative where p is on the side that cross(e, f) points to.  Within 1e-11 of itself, down
/// to 1e-28 of the product of the three lengths.  Where the plain product is not that good, the
/// difference and the products are carried in two doubles each.  [Dekker71; Shewchuk97]
double triple_product(const Vec3<double>& p, const Vec3<double>& a, const Vec3<double>& e,
                      const Vec3<double>& f);

/// The same where e = b - a and f = c - a are differences too, and what rounding takes from them
/// would tilt the plane.  0 where p is one of the corners.
double triple_product_of_corners(const Vec3<double>& p, const Vec3<double>& a,
                                 const Vec3<double>& b, const Vec3<double>& c);

/// How far `p` is above the plane of the triangle a, b, c, on the side of cross(b - a, c - a);
/// right as the triple product is, for lengths of 1e-150 to 1e150.  0 within the plane, and for a
/// triangle without area.
double height_over(const Vec3<double>& p, const Vec3<double>& a, const Vec3<double>& b,
                   const Vec3<double>& c);

/// The same over the plane of the edges e and f from a.
double height_over_edges(const Vec3<double>& p, const Vec3<double>& a, const Vec3<double>& e,
                         const Vec3<double>& f);

}  // namespace lucerna

// The projected solid angle of what a receiver sees: the integral of the cosine to the receiver's
// normal over the directions that a light covers, above the receiver's horizon.  Times a radiance
// it is the irradiance, in closed form, with nothing in the way.
//
// Well-conditioned from 1e-30 sr to the hemisphere: each form is taken where its terms do not
// cancel, and where they do the integrand itself, which is nowhere negative, is added up by Gauss's
// rule on parts small enough for it.
#pragma once

#include <span>

#include "lights/maths/vec.h"

namespace lucerna {

/// Of a flat convex polygon of three or four corners, in order around it, that all emit towards
/// the receiver [sr]; in [0, pi].  `height`: how far the receiver is off its plane, to either side,
/// known better than the corners tell it.  `normal`: unit.  Any unit of length from 1e-75 to 1e75.
/// Corners far beyond others are fine; of a receiver as near to an edge as 1e-8 of the polygon's
/// size half of the digits are left.  [Lambert60]
double polygon_projected_solid_angle(std::span<const Vec3<double>> corners,
                                     const Vec3<double>& receiver, const Vec3<double>& normal,
                                     double height);

/// Of a circular disk [sr].  `to_center` from the receiver; `axis` unit, along the disk's normal to
/// either side; `height` as above.
double disk_projected_solid_angle(const Vec3<double>& to_center, const Vec3<double>& axis,
                                  double radius, double height, const Vec3<double>& normal);

/// Of all directions within an angle of the unit vector `axis`, at most pi / 2, told by its sine
/// and its cosine [sr]: of a sphere, or of a sun.  [Snyder96]
double cap_projected_solid_angle(const Vec3<double>& axis, double sin_half, double cos_half,
                                 const Vec3<double>& normal);

}  // namespace lucerna

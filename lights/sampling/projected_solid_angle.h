// The projected solid angle of a light: the integral of the cosine to the receiver's normal over
// the light's directions above the horizon.  Multiplied by a radiance, it is the irradiance without
// occlusion, in closed form.
//
// Well-conditioned from 1e-30 sr to the hemisphere.  Each closed form is used only where its terms
// do not cancel.  Elsewhere Gauss's rule integrates over small parts; the integrand is never
// negative.
#pragma once

#include <span>

#include "lights/maths/vec.h"

namespace lucerna {

/// For a flat convex polygon of three or four corners, in order, whose side towards the receiver
/// emits [sr]; in [0, pi].  `height` is the receiver's distance from the plane, to either side.  It
/// is more exact than a height from the corners.  `normal` is unit.  Lengths may have any unit,
/// from 1e-75 to 1e75. Corners may lie at very different distances.  Half of the digits remain for
/// a receiver as near to an edge as 1e-8 of the polygon's size.  [Lambert60]
double polygon_projected_solid_angle(std::span<const Vec3> corners, const Vec3& receiver,
                                     const Vec3& normal, double height);

/// For a circular disk [sr].  `to_center` starts at the receiver.  `axis` is unit, along the disk's
/// normal to either side.  `height` as above.
double disk_projected_solid_angle(const Vec3& to_center, const Vec3& axis, double radius,
                                  double height, const Vec3& normal);

/// For all directions within an angle, at most pi / 2, of the unit vector `axis` [sr], such as
/// those of a sphere or a sun.  The angle is given by its sine and its cosine.  [Snyder96]
double cap_projected_solid_angle(const Vec3& axis, double sin_half, double cos_half,
                                 const Vec3& normal);

}  // namespace lucerna

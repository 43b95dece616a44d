// Irradiance from lights of radiance 1 in closed form, derived here by hand.  Project the visible
// part of the light onto the unit sphere about the receiver, then onto the receiver's plane.
// Irradiance is the area of that projection (Nusselt's analogue).  Each area is a contour integral,
// 1/2 of (x dy - y dx) along its edge.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
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

/// The irradiance from a whole sphere of radius `radius` about `centre`, with the receiver outside.
///
/// The sphere covers a cap of half-angle s about c, at an angle w to the normal; sin s = radius /
/// distance.  With x along the part of c within the plane, the cap's edge is p(t) = cos s c + sin s
/// (cos t e1 + sin t e2), where c = (sin w, 0, cos w), e1 = (-cos w, 0, sin w), e2 = (0, 1, 0).
/// - The cap is above the horizon, w + s <= pi/2: its edge projects to an ellipse of semi-axes
///   sin s and sin s cos w.  The area is pi sin^2 s cos w.
/// - The cap is below the horizon, w - s >= pi/2: the irradiance is 0.
/// - Otherwise the height of the edge, cos s cos w + sin s sin w cos t, is positive for |t| < T,
///   cos T = -cot s cot w.  The contour has two parts.  The first is the arc of the ellipse there.
///   Its half integral of (x dy - y dx), in the positive direction, is
///   sin^2 s cos w T - sin s cos s sin w sin T.  The second is the arc of the unit circle between
///   its ends (cos s / sin w, +- sin s sin T).  Its half integral is half its angle:
///   atan2(sin s sin T, cos s / sin w).
/// [Snyder96] has the same formula.
inline double sphere_irradiance(const Vec3& centre, double radius, const Vec3& receiver,
                                const Vec3& n) {
  constexpr double kPi = std::numbers::pi;
  const Vec3 to_centre = centre - receiver;
  const double sin_s = radius / length(to_centre);
  const double cos_s = std::sqrt((1 - sin_s) * (1 + sin_s));
  const double cos_w = dot(normalized(to_centre), n);
  const double sin_w = length(cross(normalized(to_centre), n));
  const double s = std::asin(sin_s), w = std::atan2(sin_w, cos_w);
  if (w + s <= kPi / 2) return kPi * sin_s * sin_s * cos_w;
  if (w - s >= kPi / 2) return 0;
  const double cos_t = -(cos_s / sin_s) * (cos_w / sin_w);
  const double sin_t = std::sqrt((1 - cos_t) * (1 + cos_t));
  const double t = std::acos(cos_t);
  return sin_s * sin_s * cos_w * t - sin_s * cos_s * sin_w * sin_t +
         std::atan2(sin_s * sin_t, cos_s / sin_w);
}

/// The irradiance from a disk parallel to the receiver's plane, `height` above it, with its centre
/// `offset` aside.
///
/// With p(t) = (offset + R cos t, R sin t, height) on the edge, the differential of the area is (x
/// dy - y dx) / |p|^2 / 2 = (R^2 + offset R cos t) / (S + 2 offset R cos t) dt / 2, where S =
/// offset^2 + R^2 + height^2.  The numerator equals half the denominator plus R^2 - S/2.  The
/// integral of 1 / (S + B cos t) over a turn is 2 pi / sqrt(S^2 - B^2).  For a coaxial disk the
/// result is pi R^2 / (R^2 + height^2).
inline double disk_irradiance(double radius, double height, double offset) {
  constexpr double kPi = std::numbers::pi;
  const double s = offset * offset + radius * radius + height * height;
  const double b = 2 * offset * radius;
  return kPi / 2 * (1 - (s - 2 * radius * radius) / std::sqrt((s - b) * (s + b)));
}

/// A disk about `centre` with the unit normal (0, 0, 1), for receivers at any angle.  It is a
/// polygon of 4096 corners with the disk's own area.  Its irradiance is within 1e-6 of the disk's:
/// an edge deviates by R (pi / 4096)^2 / 2 to either side.
inline std::vector<Vec3> disk_as_polygon(const Vec3& centre, double radius) {
  constexpr int kCorners = 4096;
  const double step = 2 * std::numbers::pi / kCorners;
  const double r = radius * std::sqrt(step / std::sin(step));
  std::vector<Vec3> corners;
  for (int i = 0; i < kCorners; ++i)
    corners.push_back(centre + Vec3{r * std::cos(i * step), r * std::sin(i * step), 0});
  return corners;
}

}  // namespace lucerna::testing

// The spherical triangle: the directions that a triangle covers, and points of the triangle chosen
// uniformly in solid angle.
//
// Well-conditioned from 1e-30 sr to nearly the hemisphere.  Solid angle and samples come from the
// triple product of the corners through the edges.  No angle is computed as a difference of angles.
#pragma once

#include <cmath>
#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// Above this solid angle a triangle or rectangle covers the hemisphere [sr]. Its edges then lie in
/// the receiver's horizon to within rounding.
inline constexpr double kMaxSolidAngle = 2 * kPi - 1e-6;

/// `x` clamped to [0, 1]; 0 for NaN, the result of 0 / 0.
inline double clamp_unit(double x) { return std::fmin(std::fmax(x, 0), 1); }

/// The solid angle [sr] of the triangle with a corner at `a` and edges `ab`, `ac` from it, seen
/// from the origin; in [0, 2 pi].  0 if the origin is in its plane.  Any unit of length.
/// [Oosterom83]
double triangle_solid_angle(const Vec3& a, const Vec3& ab, const Vec3& ac);
/// The same from three corners, with a `determinant` dot(a, cross(b, c)) that is more exact than
/// one computed from the corners.
double triangle_solid_angle(const Vec3& a, const Vec3& b, const Vec3& c, double determinant);

/// A value; no call allocates.
class SphericalTriangle {
 public:
  /// Corners, and the receiver in the same frame; any unit of length.  Edges are computed from the
  /// given corners, so a small distant triangle loses precision only in its direction.  Nothing if
  /// there is no density by solid angle.  Then the receiver is in the plane or on a corner, the
  /// triangle covers the hemisphere to within 1e-6 sr, or a value is not finite.
  static std::optional<SphericalTriangle> create(const Vec3& a, const Vec3& b, const Vec3& c,
                                                 const Vec3& receiver = {});

  /// The same from corners relative to the receiver, with a `determinant` dot(a, cross(b - a, c -
  /// a)) that is more exact than one computed from them.
  static std::optional<SphericalTriangle> create_seen(const Vec3& a, const Vec3& b, const Vec3& c,
                                                      double determinant);

  double solid_angle_sr() const { return solid_angle_; }

  /// Barycentric coordinates (of a, b, c) of a point, uniform in solid angle; not negative, sum 1.
  /// `u` in [0, 1]^2: u.y = 0 is b; u.y = 1 is the edge from a (u.x = 0) to c (u.x = 1).  [Arvo95]
  Vec3 sample(Vec2 u) const;

  /// The `u` that `sample` maps to these barycentric coordinates.
  Vec2 invert(const Vec3& barycentric) const;

 private:
  SphericalTriangle() = default;
  static std::optional<SphericalTriangle> create(const Vec3& a, const Vec3& b, const Vec3& ab,
                                                 const Vec3& ac, double determinant);

  /// The arc from b to the point c' of the edge ac at `t`: in units of |b|, b + s m.
  struct Arc {
    double sine, cosine;  ///< of the angle between b and m, times |m|

    /// 1 - cos of the angle between b and b + s m.
    double one_minus_cos(double s) const;
  };
  Arc arc_to(double t) const;

  Vec3 unit_a_, unit_b_, ac_, ba_;  // ac_ in units of |a|; ba_ in units of |b|
  Vec3 bisector_;                   // unit_a_ + unit_b_
  double a_by_b_;                   // |a| / |b|
  double determinant_;              // of unit_a_, unit_b_, ac_; positive
  double solid_angle_;
};

}  // namespace lucerna

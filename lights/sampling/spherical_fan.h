// Uniform sampling by solid angle of a flat convex polygon for a receiver close above it.  The
// polygon then covers nearly the whole hemisphere.
//
// The polygon is cut into triangles at the receiver's foot, the point of the polygon below the
// receiver.  An edge has the distance d from the foot; h is the height; y runs along the edge from
// its point nearest to the foot.  From that nearest point to y, such a triangle covers
//
//   G(y) = phi - asin(k sin phi),   tan phi = y / d,   k = h / sqrt(h^2 + d^2).
//
// The inverse is tan phi = sin G / (cos G - k).  All lengths are measured from the foot and not
// from a corner, so heights of 1e-20 of the polygon's size lose no precision.  (Arvo's triangle
// measures from its corners and loses the square of that ratio.  At heights of 1e-8 its samples do
// not follow its density.)
#pragma once

#include <array>
#include <optional>
#include <span>

#include "lights/maths/vec.h"

namespace lucerna {

/// A value; no call allocates.
class SphericalFan {
 public:
  /// Three or four corners from the receiver, counter-clockwise about the unit normal of their
  /// plane.  `height` is how far the receiver is above it on the side of the normal, not 0.  All in
  /// one unit of length.  Nothing if the foot is outside the polygon.  Nothing if the height
  /// exceeds a thousandth of the distance to the farthest corner, because other ways are as good
  /// there.
  static std::optional<SphericalFan> create(std::span<const Vec3> corners, const Vec3& normal,
                                            double height);

  /// Whether the height is that low; a fast test of what `create` requires.
  static bool is_low(std::span<const Vec3> corners, double height) {
    constexpr double kLow = 1e-3;
    double farthest = 0;
    for (const Vec3& c : corners) {
      const double most = max_abs(c);
      farthest = most > farthest ? most : farthest;
    }
    return std::fabs(height) > 0 && std::fabs(height) < kLow * farthest && std::isfinite(farthest);
  }

  double solid_angle_sr() const { return up_to_[count_ - 1]; }

  /// A point of the polygon, from the receiver; uniform in solid angle.  u.y = 0 is the foot,
  /// u.y = 1 the edge, u.x leads around it.  `u` in [0, 1]^2.
  Vec3 sample(Vec2 u) const;

 private:
  SphericalFan() = default;

  /// An edge, relative to the foot.
  struct Edge {
    Vec3 outwards, along;       ///< unit, within the plane
    double distance, from, to;  ///< from the foot; y at either end
    double covered_from;        ///< G(from)
  };

  double height_;
  Vec3 to_foot_;
  int count_ = 0;
  std::array<Edge, 4> edge_;
  std::array<double, 4> up_to_;  ///< running sum of what the edges cover [sr]
};

}  // namespace lucerna

// What a flat convex polygon covers of the sphere of directions for a receiver so low above it that
// this is nearly the hemisphere, and points of the polygon chosen uniformly in it.
//
// The polygon is cut into triangles from the receiver's foot, the point of it below the receiver.
// With an edge at the distance d from the foot, h the height, y along the edge from where it is
// nearest, such a triangle covers from that nearest point to y
//
//   G(y) = phi - asin(k sin phi),   tan phi = y / d,   k = h / sqrt(h^2 + d^2),
//
// and from tan G as a fraction, tan phi = sin G / (cos G - k).  No length is ever told from a
// corner but from the foot alone, so that heights of 1e-20 of the polygon's size are as good as
// others.  (Arvo's triangle, told from its corners, loses the square of the ratio: at heights of
// 1e-8 its samples have nothing to do with its density.)
#pragma once

#include <array>
#include <optional>
#include <span>

#include "lights/maths/vec.h"

namespace lucerna {

/// A value; no call allocates.
class SphericalFan {
 public:
  /// Corners from the receiver, three or four of them, counter-clockwise about the unit normal of
  /// their plane, and how far the receiver is above it on the side of the normal, not 0; in one
  /// unit of length.  Nothing where the foot is not within the polygon, nor where the height is
  /// above a thousandth of the way to the farthest corner, where others are as good.
  static std::optional<SphericalFan> create(std::span<const Vec3<double>> corners,
                                            const Vec3<double>& normal, double height);

  double solid_angle_sr() const { return up_to_[count_ - 1]; }

  /// A point of the polygon, from the receiver; uniform in solid angle.  u.y = 0 is the foot,
  /// u.y = 1 the edge, u.x leads around it.  `u` in [0, 1]^2.
  Vec3<double> sample(Vec2<double> u) const;

 private:
  SphericalFan() = default;

  /// An edge, as the foot sees it.
  struct Edge {
    Vec3<double> outwards, along;  ///< unit, within the plane
    double distance, from, to;     ///< from the foot; y at either end
    double covered_from;           ///< G(from)
  };

  double height_;
  Vec3<double> to_foot_;
  int count_ = 0;
  std::array<Edge, 4> edge_;
  std::array<double, 4> up_to_;  ///< what the edges cover with those before them [sr]
};

}  // namespace lucerna

// The spherical rectangle: the directions that a rectangle covers, and points of the rectangle
// chosen uniformly in solid angle.
#pragma once

#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// Seen from the origin.  A value; no call allocates.
class SphericalRectangle {
 public:
  /// A corner relative to the receiver and the two edges from it, perpendicular to each other; any
  /// unit of length.  Nothing below 1e-5 sr or above 2 pi - 1e-6 sr.  Callers then sample by area;
  /// sampling and density use the same thresholds.  Most smaller rectangles are so far away that
  /// all ways are equal.  The others are nearly edge-on: samples lose digits, about five of sixteen
  /// at 1e-5 sr.
  static std::optional<SphericalRectangle> create(const Vec3& corner, const Vec3& edge_x,
                                                  const Vec3& edge_y);
  /// The same with a more exact height of the receiver above the plane, to either side.
  static std::optional<SphericalRectangle> create(const Vec3& corner, const Vec3& edge_x,
                                                  const Vec3& edge_y, double height);

  /// Computed by two triangles, because a sum of four angles cancels.  [Oosterom83]  They share a
  /// diagonal, so one arctangent gives the sum of both.
  double solid_angle_sr() const { return solid_angle_; }

  /// The position along both edges as fractions in [0, 1]^2, uniform in solid angle. u = (0, 0) is
  /// the corner, u.x runs along edge_x, u.y along edge_y.  [Urena13]
  Vec2 sample(Vec2 u) const;

  /// The `u` that `sample` maps to these fractions.
  Vec2 invert(Vec2 shares) const;

 private:
  SphericalRectangle() = default;

  /// The solid angle of the part between 0 and `x`, with the sign of x.
  double strip(double x) const;

  double x0_, y0_, x1_, y1_, z_;  // the receiver's foot is the origin of the plane z = z_ > 0
  double solid_angle_;
  double distance00_, distance01_;  // of both corners at x0
};

}  // namespace lucerna

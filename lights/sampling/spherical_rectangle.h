// The spherical rectangle: what a rectangle covers of the sphere of directions, and points of the
// rectangle chosen uniformly in it.
#pragma once

#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// Seen from the origin.  A value; no call allocates.
class SphericalRectangle {
 public:
  /// A corner relative to the receiver and the two edges from there, perpendicular to each other;
  /// any unit of length.  Nothing below 1e-5 sr or above 2 pi - 1e-6 sr, where points are to be
  /// chosen by area: the one threshold for sampling and density.  Smaller rectangles are either so
  /// far that all ways are alike, or seen so nearly from within their plane that the cosines below
  /// lose what tells them apart (at 1e-5 sr ten of sixteen digits are lost).
  static std::optional<SphericalRectangle> create(const Vec3<double>& corner,
                                                  const Vec3<double>& edge_x,
                                                  const Vec3<double>& edge_y);
  /// The same where the receiver's height above the plane, to either side, is known better.
  static std::optional<SphericalRectangle> create(const Vec3<double>& corner,
                                                  const Vec3<double>& edge_x,
                                                  const Vec3<double>& edge_y, double height);

  /// By two triangles: a sum of four angles cancels.  [Oosterom83]
  double solid_angle_sr() const { return solid_angle_; }

  /// Shares of the edges, in [0, 1]^2, uniform in solid angle.  u = (0, 0) is the corner, u.x leads
  /// along edge_x, u.y along edge_y.  [Urena13]
  Vec2<double> sample(Vec2<double> u) const;

  /// The `u` that leads to these shares.
  Vec2<double> invert(Vec2<double> shares) const;

 private:
  SphericalRectangle() = default;

  /// The solid angle of the part between 0 and `x`, with the sign of x.
  double strip(double x) const;

  double x0_, y0_, x1_, y1_, z_;  // the receiver's foot is the origin of the plane z = z_ > 0
  double sin_y0_, sin_y1_;        // of the elevation of both edges along x
  double strip_x0_;
  double solid_angle_;
};

}  // namespace lucerna

// The spherical ellipse: the directions that a disk covers, and points of the disk chosen nearly
// uniformly in solid angle.
//
// As in [Guillen17], sampling starts from the middle of the ellipse and is uniform in 1 - cos along
// each meridian. In [Guillen17] the meridian is also uniform in solid angle.  This needs the
// inverse of an elliptic integral by tables or iterations, which limit the precision of the
// density.  Here meridians are uniform in the angle t of the ellipse's edge in the form
//
//   (sin alpha cos t, sin beta sin t, n(t)),
//   n(t)^2 = 1 - sin^2 alpha cos^2 t - sin^2 beta sin^2 t,
//
// These are unit vectors about the middle.  alpha and beta are the half-angles of the axes.  The
// density of a direction then has a closed form, where t belongs to its meridian:
//
//   p = (1 + n(t)) / (2 pi sin alpha sin beta).
//
// It is uniform for circles and nearly uniform for small or round ellipses. It never varies by more
// than (1 + cos beta) / (1 + cos alpha), which is less than 2. (Along the meridian of azimuth phi,
// the density of 1 - cos is 1 / (1 - n).  And dt / dphi / (2 pi) = (1 - n^2) / (2 pi sin alpha sin
// beta).)
#pragma once

#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// A value; no call allocates.
class SphericalEllipse {
 public:
  /// A disk of `radius` in a plane `height` above the receiver, its centre `offset` aside; not
  /// negative, in any unit of length.
  ///
  /// Nothing if the half-angle beta of the short axis is below 1e-5.  Such disks are so far away
  /// that all ways are equal, or so nearly edge-on that `float` points cannot hold the height.
  /// Nothing if alpha is within 1e-5 of a right angle and beta is not within 1e-3 of one: the
  /// receiver is then just above the rim.  Callers sample by area then.  Sampling and density use
  /// the same thresholds.
  static std::optional<SphericalEllipse> create(double offset, double height, double radius);

  /// A point of the disk: x along the offset (away from the receiver), y across.
  struct Point {
    Vec2 from_center;
    Vec2 from_foot;  ///< from the point below the receiver; exact at any distance
  };
  Point choose(Vec2 u) const;
  /// The point from the centre only.
  Vec2 sample(Vec2 u) const { return choose(u).from_center; }

  /// Density with respect to solid angle at a point of the disk [1/sr].
  double pdf(Vec2 point) const;

 private:
  SphericalEllipse() = default;

  /// n(t)^2 of the meridian through (sin alpha x, sin beta y).
  double squared_edge(double x, double y) const;

  int exponent_;  // of the unit of length that the rest is in
  double radius_, height_;
  double axis_, foot_axis_;  // x where the middle's direction meets the plane, from the centre and
                             // from the foot
  double to_axis_;           // distance of that point from the receiver
  double sin_alpha_, cos_alpha_;  // across
  double sin_beta_, cos_beta_;    // along
  double sin_tilt_, cos_tilt_;    // of the middle, off the disk's normal
};

}  // namespace lucerna

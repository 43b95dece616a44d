// A whole sphere seen from a point, and points of it chosen by direction.
#pragma once

#include "lights/maths/vec.h"

namespace lucerna {

/// A sphere as a viewpoint sees it.
struct SeenSphere {
  Vec3 to_center;   ///< from the viewpoint [m]
  double distance;  ///< length of `to_center` [m]
  double radius_m;

  /// A point of the sphere.
  struct Point {
    Vec3 from_center;   ///< [m]
    Vec3 normal;        ///< outwards, unit
    double pdf_per_sr;  ///< of its direction
    /// From the viewpoint [m].  0: the difference of the positions is as exact.
    Vec3 to_point{};
  };

  /// The density of `from_outside` [1/sr].  Both require a distance greater than the radius.
  double pdf_from_outside() const;
  /// The point of the near side in a direction chosen uniformly among those that meet the sphere; u
  /// in [0, 1]^2.  [Pharr23, 6.2.4]
  Point from_outside(Vec2 u) const;
  /// The point in a direction chosen uniformly.  Requires a distance less than the radius.
  Point from_within(Vec2 u) const;
};

}  // namespace lucerna

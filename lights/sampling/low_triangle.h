// A triangle as a receiver sees it that is low above its plane and near to it: from the foot, the
// point of the plane below the receiver, where the triangle holds it; else from the point of the
// triangle that is nearest to the foot.  Told from a corner instead, what is seen next to the foot
// would be lost in the length of the way there.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "lights/maths/vec.h"
#include "lights/sampling/spherical_fan.h"
#include "lights/sampling/spherical_triangle.h"

namespace lucerna {

/// A value; no call allocates.
class LowTriangle {
 public:
  /// Corners from the receiver, counter-clockwise about the unit normal, and how far the receiver
  /// is above the plane on the side of the normal, not 0; in one unit of length.  Nothing where the
  /// receiver is not within a thousandth of the triangle's size of it: there
  /// lights/sampling/spherical_triangle.h is as good.
  static std::optional<LowTriangle> create(std::span<const Vec3<double>, 3> corners,
                                           const Vec3<double>& normal, double height);

  double solid_angle_sr() const;

  /// A point of the triangle, from the receiver; uniform in solid angle.  `u` in [0, 1]^2.
  Vec3<double> sample(Vec2<double> u) const;

 private:
  LowTriangle() = default;

  /// Seen from beside: the parts to both sides of the nearest point, which is corner b of each.
  struct Part {
    SphericalTriangle seen;
    Vec3<double> to_a, to_c;  ///< from the nearest point
  };
  std::optional<SphericalFan> fan_;
  std::array<std::optional<Part>, 2> part_;
  Vec3<double> nearest_;  ///< from the receiver
};

}  // namespace lucerna

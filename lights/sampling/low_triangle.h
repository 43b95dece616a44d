// A triangle seen by a receiver that is close to it and low above its plane. Positions are relative
// to the foot, the point of the plane below the receiver, if the triangle contains it.  Otherwise
// they are relative to the point of the triangle nearest to the foot.  Coordinates relative to a
// corner would lose digits near the foot.
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
  /// Corners from the receiver, counter-clockwise about the unit normal.  `height` is how far the
  /// receiver is above the plane on the side of the normal, not 0.  All in one unit of length.
  /// Nothing if the receiver is farther away than a thousandth of the triangle's size.  There
  /// lights/sampling/spherical_triangle.h is as good.
  static std::optional<LowTriangle> create(std::span<const Vec3, 3> corners, const Vec3& normal,
                                           double height);

  double solid_angle_sr() const;

  /// A point of the triangle, from the receiver; uniform in solid angle.  `u` in [0, 1]^2.
  Vec3 sample(Vec2 u) const;

 private:
  LowTriangle() = default;

  /// If the foot is outside: the parts on both sides of the nearest point, which is corner b of
  /// each part.
  struct Part {
    SphericalTriangle seen;
    Vec3 to_a, to_c;  ///< from the nearest point
  };
  std::optional<SphericalFan> fan_;
  std::array<std::optional<Part>, 2> part_;
  Vec3 nearest_;  ///< from the receiver
};

}  // namespace lucerna

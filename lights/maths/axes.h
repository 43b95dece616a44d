// The three axes of lights that are not symmetric about an axis.
#pragma once

#include "lights/maths/validation.h"

namespace lucerna {

/// OK where the three are directions at right angles, of any lengths and either handedness.
inline absl::Status check_right_angles(std::string_view field, const Frame& axes) {
  for (const Vec3& axis : {axes.s, axes.t, axes.n})
    if (auto s = check_direction(field, axis); !s.ok()) return s;
  const Vec3 s = normalized(axes.s), t = normalized(axes.t), n = normalized(axes.n);
  // Axes written with six digits have errors of this size.  Products of rotations in double have
  // far smaller ones.
  constexpr double kTolerance = 1e-5;
  if (std::fabs(dot(s, t)) <= kTolerance && std::fabs(dot(t, n)) <= kTolerance &&
      std::fabs(dot(n, s)) <= kTolerance)
    return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format(
      "{} = ({}, {}, {}), ({}, {}, {}), ({}, {}, {}), allowed: at right angles to each other",
      field, axes.s.x, axes.s.y, axes.s.z, axes.t.x, axes.t.y, axes.t.z, axes.n.x, axes.n.y,
      axes.n.z));
}

/// Unit vectors exactly at right angles.  The last axis keeps its direction, and the frame keeps
/// its handedness.
inline Frame orthonormal(const Frame& axes) {
  const Vec3 n = normalized(axes.n);
  const Vec3 s0 = normalized(axes.s);
  const Vec3 s = normalized(s0 - n * dot(s0, n));
  const Vec3 t = cross(n, s);
  return {s, dot(t, axes.t) < 0 ? -t : t, n};
}

}  // namespace lucerna

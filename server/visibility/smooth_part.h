// A flat mirror, a pane, a face of glass, or a mirror ball.
#pragma once

#include <cstdint>
#include <utility>

#include "lights/maths/vec.h"

namespace lucerna {

/// Faces in one plane, or a whole sphere, of one material.  About the scene's origin [m].
struct SmoothPart {
  bool is_sphere = false;  ///< reflects on its outside only
  bool reflects = false;
  /// Whether light passes it in a single direction.  Panes that direct light passes do not count.
  bool refracts = false;
  /// Of a plane that is nearly a mirror: the roughness alpha of its facets; else 0.
  double glossy_alpha = 0;
  /// The index on the side to which -n points, over that to which n points.
  double eta = 1;
  /// The share of light that it reflects along its normal, at some point of it.  For choices only.
  double reflected = 0;
  std::uint32_t material = 0;
  /// Of a plane: unit, on the outside.
  Vec3 n{};
  /// Of a plane: the middle of a rectangle that contains the faces, and half its edges.  Of a
  /// sphere: its centre.
  Vec3 middle{}, half_u{}, half_v{};
  double radius_m = 0;  ///< of a sphere

  /// The height of `p` over the plane, on the side of n [m].
  double height(const Vec3& p) const { return dot(n, p - middle); }
  /// The lowest and the highest corner of this rectangle over the plane of `other` [m].
  std::pair<double, double> heights_over(const SmoothPart& other) const;
  /// Whether a point of the plane lies within the rectangle, or within a thousandth of it.
  bool may_contain(const Vec3& p) const;
};

}  // namespace lucerna

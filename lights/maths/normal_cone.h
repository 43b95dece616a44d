// Data of a shape for rays that leave it: the directions of its normals, and how far rounding may
// move a point off it.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lights/maths/vec.h"

namespace lucerna {

/// All normals of a shape lie within `half_angle_rad` of `axis`.
struct NormalCone {
  Vec3 axis{0, 0, 1};  ///< unit
  double half_angle_rad = std::numbers::pi;
};

/// A bound on the angle between a normal of a curved shape and the cone that is computed without
/// its map.  Maps count as of equal scale up to 1e-6, which turns normals by at most twice that.
/// Rounding to float adds to it.
inline constexpr double kNormalSlackRad = 4e-6;

/// The angle between vectors of any length but 0; exact for parallel ones too.
inline double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(length(cross(a, b)), dot(a, b));
}

/// The distance by which rounding to float may move a point off a shape within these bounds [m].
inline double rounding_m(const std::pair<Vec3, Vec3>& bounds) {
  return 16 * kInputRounding * std::fmax(max_abs(bounds.first), max_abs(bounds.second));
}

}  // namespace lucerna

// What a shape tells of itself for rays that leave it: the directions its normals take, and how far
// a point may be off it by rounding alone.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lights/maths/vec.h"

namespace lucerna {

/// All normals of a shape lie within `half_angle_rad` of `axis`.
template <std::floating_point Real>
struct NormalCone {
  Vec3<Real> axis{0, 0, 1};  ///< unit
  double half_angle_rad = std::numbers::pi;
};

/// What a normal of a curved shape may be off the cone worked out without its map: maps count as of
/// equal scale up to 1e-6, which turns normals by no more than twice that, and floats round.
inline constexpr double kNormalSlackRad = 4e-6;

/// The angle between vectors of any length but 0; exact for parallel ones too.
inline double angle_between(const Vec3<double>& a, const Vec3<double>& b) {
  return std::atan2(length(cross(a, b)), dot(a, b));
}

/// How far a point computed on a shape within these bounds may be off it, rounded to float [m].
template <std::floating_point Real>
double rounding_m(const std::pair<Vec3<Real>, Vec3<Real>>& bounds) {
  return 16 * kInputRounding *
         std::fmax(max_abs(Vec3<double>(bounds.first)), max_abs(Vec3<double>(bounds.second)));
}

}  // namespace lucerna

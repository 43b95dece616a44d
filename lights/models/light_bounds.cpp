#include "lights/models/light_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace lucerna {

// Tests two conditions that each direction from the box to `position` within the cone satisfies.
// The angle to the box's bounding sphere is a good bound far away and for narrow cones.  The
// heights above the box's corners are a good bound for flat boxes, whose sphere is far too large.
// NaN counts as reached.
bool LightBounds::reaches(const Vec3& position) const {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const Vec3 p(position), low(lower), high(upper);
  // Normalised in double: the rounding of its length to float would be an error of every height.
  const Vec3 n = normalized(axis);
  // Sums of a few products of these lengths, each rounded once or twice.
  const double slack = 16 * kEpsilon * (max_abs(p) + max_abs(low) + max_abs(high));

  const Vec3 to_p = p - (low * 0.5 + high * 0.5);
  const double distance = length(to_p);
  const double radius = length(high * 0.5 - low * 0.5) + slack;
  if (distance > radius) {
    const double angle = std::atan2(length(cross(n, to_p)), dot(n, to_p));
    if (angle - std::asin(radius / distance) > cone_rad + 16 * kEpsilon) return false;
  }

  // The largest height of `position` above a point of the box, along the axis; its least and
  // largest distance.
  double height = 0;
  Vec3 near, far;
  const auto along = [&](double at, double a, double b, double cos, double& least, double& most) {
    height += std::max((at - a) * cos, (at - b) * cos);
    least = std::max({0.0, a - at, at - b});
    most = std::max(std::fabs(at - a), std::fabs(at - b));
  };
  along(p.x, low.x, high.x, n.x, near.x, far.x);
  along(p.y, low.y, high.y, n.y, near.y, far.y);
  along(p.z, low.z, high.z, n.z, near.z, far.z);
  const double cos = std::cos(std::min(cone_rad, std::numbers::pi));
  return !(height < cos * length(cos > 0 ? near : far) - slack);
}

}  // namespace lucerna

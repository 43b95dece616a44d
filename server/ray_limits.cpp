#include "server/ray_limits.h"

#include <algorithm>
#include <cmath>

namespace lucerna {

RayLimits limits_for(float extent, double magnified) {
  const int instance_exponent = std::ilogb(magnified) + 1;
  RayLimits limits{.max_origin = std::scalbn(1.0f, 59 - instance_exponent)};
  if (extent > 0 && std::isfinite(extent))
    limits.direction_exponent = std::max(20 - 2 * std::ilogb(extent), -50);
  limits.direction_exponent = std::min(limits.direction_exponent, 58 - instance_exponent);
  return limits;
}

double magnification(const Transform& scene_from_object) {
  const Transform inverse = scene_from_object.inverse();
  double largest = 1;
  for (const auto& row : inverse.matrix()) {
    largest = std::max(largest, std::fabs(row[0]) + std::fabs(row[1]) + std::fabs(row[2]));
    if (!(std::fabs(row[3]) < 0x1p58)) return INFINITY;
  }
  return largest;
}

}  // namespace lucerna

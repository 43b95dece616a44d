#include "server/rays/ray_limits.h"

#include <algorithm>
#include <cmath>

namespace lucerna {

std::optional<Entry> entry_from_afar(const Vec3& origin_m, const Vec3& direction, double reach_m) {
  const double largest = max_abs(origin_m);
  const Vec3 from = origin_m / largest, w = normalized(direction);
  const double along = -dot(from, w), radius = 2 * (reach_m / largest);
  const Vec3 off = from + w * along;
  if (!(along > 0) || !(dot(off, off) < radius * radius)) return std::nullopt;
  const double entry = along - std::sqrt(radius * radius - dot(off, off));
  return Entry{(off + w * (entry - along)) * largest, entry * largest / length(direction)};
}

double unit_for(double reach_m) {
  return reach_m > 0 && std::isfinite(reach_m) ? std::exp2(std::ilogb(reach_m) - kReachExponent)
                                               : 1;
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

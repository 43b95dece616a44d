#include "server/ray_limits.h"

#include <algorithm>
#include <cmath>

namespace lucerna {
namespace {

/// Beyond so many times the reach rays are moved.
constexpr double kFar = 16;

}  // namespace

std::optional<UnitRay> unit_ray(const Vec3<double>& origin_m, const Vec3<double>& direction,
                                double t_min, double t_max, const RaySpace& space) {
  const double longest = max_abs(direction);
  if (!is_finite(origin_m) || !is_finite(direction) || !(longest > 0) || std::isnan(t_min) ||
      std::isnan(t_max))
    return std::nullopt;
  const int exponent = space.direction_exponent - exponent_of(longest);
  const Vec3<double> d = scaled(direction, exponent);
  Vec3<double> o = origin_m;
  UnitRay ray{};
  ray.units = scaled(space.unit_m, exponent);
  if (max_abs(o) > kFar * space.reach_m) [[unlikely]] {
    // A sphere about zero that holds all: from where the ray enters it.
    const double largest = max_abs(o);
    const Vec3<double> from = o / largest, w = normalized(direction);
    const double along = -dot(from, w), radius = 2 * (space.reach_m / largest);
    const Vec3<double> off = from + w * along;
    if (!(along > 0) || !(dot(off, off) < radius * radius)) return std::nullopt;
    const double entry = along - std::sqrt(radius * radius - dot(off, off));
    o = (off + w * (entry - along)) * largest;
    ray.start = entry * largest / length(direction);
  }
  ray.origin = Vec3<float>(o / space.unit_m), ray.direction = Vec3<float>(d);
  if (ray.start > 0) t_min = std::max(t_min, ray.start);
  ray.t_min = static_cast<float>((t_min - ray.start) / ray.units);
  ray.t_max = static_cast<float>((t_max - ray.start) / ray.units);
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

double unit_for(double reach_m) {
  return reach_m > 0 && std::isfinite(reach_m) ? std::exp2(std::ilogb(reach_m)) : 1;
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

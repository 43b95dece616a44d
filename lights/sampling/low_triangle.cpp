#include "lights/sampling/low_triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucerna {

std::optional<LowTriangle> LowTriangle::create(std::span<const Vec3, 3> corners, const Vec3& normal,
                                               double height) {
  constexpr double kNear = 1e-3;
  const double farthest = std::max({max_abs(corners[0]), max_abs(corners[1]), max_abs(corners[2])});
  if (!(std::fabs(height) < kNear * farthest)) return std::nullopt;
  LowTriangle low;
  low.fan_ = SphericalFan::create(corners, normal, height);
  if (low.fan_) return low;

  // Find the nearest of the edges that have the foot on their outer side.
  double least = std::numeric_limits<double>::infinity();
  Vec3 from_foot;
  int edge = -1;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % 3];
    const Vec3 along = normalized(b - a);
    const Vec3 outwards = cross(along, normal);
    const double beyond = -dot(a, outwards);
    if (!(beyond > 0)) continue;
    const double from = dot(a, along), to = dot(b, along);
    const double y = std::clamp(0.0, std::min(from, to), std::max(from, to));
    const double distance = std::hypot(beyond, y);
    if (distance >= least) continue;
    least = distance, edge = i;
    from_foot = along * y - outwards * beyond;
  }
  if (edge < 0 || !(least < kNear * farthest)) return std::nullopt;
  low.nearest_ = normal * -height + from_foot;
  const Vec3 &next = corners[(edge + 1) % 3], &across = corners[(edge + 2) % 3];
  const auto part = [&](const Vec3& a, const Vec3& c) -> std::optional<Part> {
    const Vec3 to_a = a - low.nearest_, to_c = c - low.nearest_;
    const double determinant = height * dot(cross(to_a, to_c), normal);
    const auto seen = SphericalTriangle::create_seen(a, low.nearest_, c, determinant);
    if (!seen) return std::nullopt;
    return Part{*seen, to_a, to_c};
  };
  low.part_ = {part(next, across), part(across, corners[edge])};
  if (!low.part_[0] && !low.part_[1]) return std::nullopt;
  return low;
}

double LowTriangle::solid_angle_sr() const {
  if (fan_) return fan_->solid_angle_sr();
  double sum = 0;
  for (const auto& p : part_)
    if (p) sum += p->seen.solid_angle_sr();
  return sum;
}

Vec3 LowTriangle::sample(Vec2 u) const {
  if (fan_) return fan_->sample(u);
  double target = std::clamp(u.x, 0.0, 1.0) * solid_angle_sr();
  const double first = part_[0] ? part_[0]->seen.solid_angle_sr() : 0;
  const bool is_first = !part_[1] || (part_[0] && target <= first);
  const Part& part = is_first ? *part_[0] : *part_[1];
  if (!is_first) target -= first;
  const Vec3 b = part.seen.sample({std::fmin(target / part.seen.solid_angle_sr(), 1), u.y});
  return nearest_ + part.to_a * b.x + part.to_c * b.z;
}

}  // namespace lucerna

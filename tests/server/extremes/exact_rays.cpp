// Rays along all primitives, and how near to edges they pass.
#include "tests/server/extremes/exact_rays.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lucerna::testing {

bool ExactGeometry::is_convex(const Primitive& p, const ExactRay& ray) {
  Point out = ray.origin - p.at[0];
  if (p.kind == Kind::kCylinder) out = out - p.normal * dot(out, p.normal);
  return dot(out, ray.from_normal) > 0;
}

void ExactGeometry::drop_nearest(ExactAnswer& answer, std::size_t first, double t) {
  if (first == answer.crossings.size()) return;
  const auto begin = answer.crossings.begin() + static_cast<std::ptrdiff_t>(first);
  const auto nearest = std::min_element(
      begin, answer.crossings.end(),
      [&](const auto& a, const auto& b) { return std::fabs(a.t - t) < std::fabs(b.t - t); });
  if (std::fabs(nearest->t - t) <= 2 * nearest->slack_t) {
    answer.crossings.erase(nearest);
  } else {
    for (auto c = begin; c != answer.crossings.end(); ++c) c->sure = false;
  }
}

ExactAnswer ExactGeometry::along(const ExactRay& ray) const {
  ExactAnswer answer;
  const double dd = dot(ray.direction, ray.direction), length_d = std::sqrt(dd);
  const Point w = ray.direction / length_d;
  for (int i = 0; i < size(); ++i) {
    const Primitive& p = primitives_[i];
    const Point to_centre = p.centre - ray.origin;
    const double along = dot(to_centre, w), square = dot(to_centre, to_centre);
    const double off = p.reach + 2 * (ray.start_error + ray.end_error + p.error + kFar * rounding_);
    if (along < -off || square - along * along > off * off) continue;
    const double error = ray.start_error + ray.end_error + rounding_ + p.error +
                         kTraversalBound * (std::sqrt(square) + p.reach);
    const std::size_t before = answer.crossings.size();
    const Meeting m{ray, w, length_d, error, i, answer.crossings};
    switch (p.kind) {
      case Kind::kTriangle:
        if (i == ray.from || i == ray.to)
          meet_end(p, m);
        else
          meet_triangle(p, m);
        break;
      case Kind::kSphere:
        if (i != ray.from || !is_convex(p, ray)) meet_sphere(p, m);
        break;
      case Kind::kDisk:
        if (i == ray.from || i == ray.to)
          meet_end(p, m);
        else
          meet_disk(p, m);
        break;
      case Kind::kCylinder:
        if (i != ray.from || !is_convex(p, ray)) meet_cylinder(p, m);
        break;
      case Kind::kPatch:
        meet_patch(p, m);
        break;
    }
    const bool is_round = p.kind != Kind::kTriangle && p.kind != Kind::kDisk;
    if (i == ray.from && is_round) drop_nearest(answer, before, 0);
    if (i == ray.to && is_round) drop_nearest(answer, before, 1);
    // The remaining crossing must lie on the ray; near the ends it is unsure.
    std::erase_if(answer.crossings, [&](ExactCrossing& c) {
      if (c.primitive != i) return false;
      const bool near_start = std::fabs(c.t) <= c.slack_t;
      const bool near_end = std::fabs(c.t - ray.t_max) <= c.slack_t;
      if (near_start || near_end) c.sure = false;
      return !near_start && !near_end && !(c.t > 0 && c.t < ray.t_max);
    });
  }
  return answer;
}

ExactGeometry::Side ExactGeometry::side_of(const Primitive& p, int e, const Meeting& m,
                                           double& value) const {
  const Point a = p.at[e] - m.ray.origin, b = p.at[(e + 1) % 3] - m.ray.origin;
  value = p.edge_up[e] ? dot(m.w, cross(a, b)) : -dot(m.w, cross(b, a));
  if (std::fabs(value) > m.error * length(b - a)) return Side::kFar;
  if (p.neighbour[e] < 0) return Side::kBorder;
  const Primitive& other = primitives_[p.neighbour[e]];
  const double facing = dot(p.normal, m.w), facing_other = dot(other.normal, m.w);
  const bool decides = std::min(std::fabs(facing) * p.shortest,
                                std::fabs(facing_other) * other.shortest) > 4 * m.error;
  return facing * facing_other > 0 && decides ? Side::kEdge : Side::kBorder;
}

bool ExactGeometry::is_near_border(int i, const Meeting& m) const {
  std::vector<int> fan{i};
  for (std::size_t k = 0; k < fan.size(); ++k) {
    if (fan[k] == m.ray.from || fan[k] == m.ray.to) return true;
    for (int e = 0; e < 3; ++e) {
      const Primitive& p = primitives_[fan[k]];
      double value;
      const Side side = side_of(p, e, m, value);
      if (side == Side::kBorder) return true;
      if (side == Side::kEdge && std::ranges::find(fan, p.neighbour[e]) == fan.end())
        fan.push_back(p.neighbour[e]);
    }
  }
  return false;
}

}  // namespace lucerna::testing

// Where a ray meets one primitive, by kind of primitive.
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/server/extremes/exact_rays.h"

namespace lucerna::testing {

void ExactGeometry::meet_triangle(const Primitive& p, const Meeting& m) const {
  std::array<double, 3> values;
  std::array<Side, 3> sides;
  for (int e = 0; e < 3; ++e) sides[e] = side_of(p, e, m, values[e]);
  // Near a corner the three numbers may disagree: the ray may be on any triangle around it.
  const bool at_corner = std::ranges::count(sides, Side::kEdge) >= 2;
  int above = 0, below = 0;
  bool on_edge = false, border = false;
  // A neighbour that is seen more edge-on may be met farther away.
  const double facing = dot(p.normal, m.w);
  double least_facing = std::fabs(facing);
  for (int e = 0; e < 3; ++e) {
    if (sides[e] == Side::kEdge)
      least_facing =
          std::min(least_facing, std::fabs(dot(primitives_[p.neighbour[e]].normal, m.w)));
    const bool either = sides[e] == Side::kBorder || (at_corner && sides[e] == Side::kEdge);
    above += values[e] >= 0 || either;
    below += values[e] <= 0 || either;
    on_edge |= sides[e] == Side::kEdge;
    border |= sides[e] == Side::kBorder;
  }
  if (above < 3 && below < 3) return;
  if (on_edge && !border) border = is_near_border(m.primitive, m);
  // The crossing of nearly parallel rays may be anywhere, so its slack makes it unsure.
  const double h = dot(p.normal, p.at[0] - m.ray.origin);
  const double plane_error = m.error + (p.slack - 1) * kTraversalBound * p.reach;
  if (std::fabs(facing) < 1e-14) {
    if (std::fabs(h) <= plane_error) m.out.push_back({0, 1e300, false, false, m.primitive});
    return;
  }
  // Around a corner the numbers of the traversal may disagree too: one ray in 1e4 passes between
  // them.
  m.add(h / (facing * m.length_d), p.normal, !border && !at_corner,
        plane_error * (std::fabs(facing) / least_facing), on_edge);
}

void ExactGeometry::meet_end(const Primitive& p, const Meeting& m) {
  const Point other = m.primitive == m.ray.to ? m.ray.origin : m.ray.origin + m.ray.direction;
  if (m.ray.t_max == 1 && std::fabs(dot(p.normal, other - p.at[0])) <= m.error)
    m.out.push_back({0, 1e300, false, false, m.primitive});
}

void ExactGeometry::meet_disk(const Primitive& p, const Meeting& m) {
  const Point to = p.at[0] - m.ray.origin;
  const double facing = dot(p.normal, m.w), h = dot(p.normal, to);
  if (std::fabs(facing) < 1e-14) {
    if (std::fabs(h) <= m.error) m.out.push_back({0, 1e300, false, false, m.primitive});
    return;
  }
  const double distance = h / facing;
  const double off = length(m.w * distance - to) - p.radius;
  if (off * std::fabs(facing) > m.error) return;
  m.add(distance / m.length_d, p.normal, off * std::fabs(facing) < -m.error, m.error);
}

void ExactGeometry::meet_sphere(const Primitive& p, const Meeting& m) {
  const Point to = p.at[0] - m.ray.origin;
  const double along = dot(to, m.w);
  const double passing = length(to - m.w * along);
  if (passing > p.radius + m.error) return;
  const bool sure = passing < p.radius - m.error;
  const double half = std::sqrt(std::max(0.0, (p.radius - passing) * (p.radius + passing)));
  for (const double d : {along - half, along + half})
    m.add(d / m.length_d, (m.w * d - to) / p.radius, sure, m.error);
}

void ExactGeometry::meet_cylinder(const Primitive& p, const Meeting& m) {
  const Point to = p.at[0] - m.ray.origin;
  const Point to_2d = to - p.normal * dot(to, p.normal), w_2d = m.w - p.normal * dot(m.w, p.normal);
  const double w2 = length(w_2d);
  if (w2 < 1e-9) {  // along the axis
    if (std::fabs(length(to_2d) - p.radius) <= m.error)
      m.out.push_back({0, 1e300, false, false, m.primitive});
    return;
  }
  const Point w_unit = w_2d / w2;
  const double along = dot(to_2d, w_unit), passing = length(to_2d - w_unit * along);
  if (passing > p.radius + m.error) return;
  const bool sure = passing < p.radius - m.error;
  const double half = std::sqrt(std::max(0.0, (p.radius - passing) * (p.radius + passing)));
  for (const double d_2d : {along - half, along + half}) {
    const double d = d_2d / w2;
    const Point normal = (w_unit * d_2d - to_2d) / p.radius;
    const double off = std::fabs(dot(m.w * d - to, p.normal)) - p.half_height;
    const double border = m.error / std::max(std::fabs(dot(normal, m.w)), 1e-300);
    if (off > border) continue;
    m.add(d / m.length_d, normal, sure && off < -border, m.error);
  }
}

// Two planes that contain the ray cut the patch, which gives two bilinear equations (Ramsey,
// Potter, Hansen 2004).
void ExactGeometry::meet_patch(const Primitive& p, const Meeting& m) {
  const Frame frame = Frame::around(m.w);
  const Point e = p.at[1] - p.at[0], f = p.at[2] - p.at[0],
              g = (p.at[3] - p.at[2]) - (p.at[1] - p.at[0]), to = p.at[0] - m.ray.origin;
  const double a1 = dot(frame.s, g), b1 = dot(frame.s, e), c1 = dot(frame.s, f),
               d1 = dot(frame.s, to);
  const double a2 = dot(frame.t, g), b2 = dot(frame.t, e), c2 = dot(frame.t, f),
               d2 = dot(frame.t, to);
  const double qa = b1 * a2 - b2 * a1, qb = b1 * c2 + d1 * a2 - b2 * c1 - d2 * a1,
               qc = d1 * c2 - d2 * c1;
  double discriminant = qb * qb - 4 * qa * qc;
  // Where the two solutions nearly coincide, the ray passes the silhouette.  Its distance is then
  // unknown.  The bound is how near a shift by the error may move it.
  const auto size = [](double x, double y) { return std::fabs(x) + std::fabs(y); };
  const double scale_b = size(b1 * c2, d1 * a2) + size(b2 * c1, d2 * a1);
  const double scale = scale_b * scale_b + 4 * size(b1 * a2, b2 * a1) * size(d1 * c2, d2 * c1);
  const bool apart = std::fabs(discriminant) > 1e-4 * scale;
  if (discriminant < 0 && apart) return;
  discriminant = std::sqrt(std::max(0.0, discriminant));
  const double q = -(qb + std::copysign(discriminant, qb)) / 2;
  for (const double u : {qc / q, q / qa}) {
    if (!std::isfinite(u) || std::fabs(u) > 1e6) continue;
    const double n1 = u * a1 + c1, n2 = u * a2 + c2;
    const double v = std::fabs(n1) > std::fabs(n2) ? -(u * b1 + d1) / n1 : -(u * b2 + d2) / n2;
    if (!std::isfinite(v) || std::fabs(v) > 1e6) continue;
    const Point at = to + e * u + f * v + g * (u * v);
    const Point normal = normalized(cross(e + g * v, f + g * u));
    const double border = m.error / (p.shortest * std::max(std::fabs(dot(normal, m.w)), 1e-300));
    const double off = std::max({-u, u - 1, -v, v - 1});
    if (off > border) continue;
    m.add(dot(at, m.w) / m.length_d, normal, apart && off < -border, m.error);
  }
}

}  // namespace lucerna::testing

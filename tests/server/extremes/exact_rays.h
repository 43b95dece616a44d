// What rays meet, worked out in double for one primitive after the other and by other formulas than
// the server's; with it what nobody can tell who has rays and vertices in floats: what passes an
// edge, a silhouette or an end within the error bounds that server/error_bounds.h states.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "lights/transform.h"
#include "lights/vec.h"
#include "server/error_bounds.h"

namespace lucerna::testing {

using Point = Vec3<double>;

/// A ray from `origin`, t in units of `direction`; segments end at t = 1.
struct ExactRay {
  Point origin, direction;
  double t_max = std::numeric_limits<double>::infinity();
  double start_error = 0;  ///< how far off the origin may be [m]
  double end_error = 0;    ///< of a segment, its end [m]
  int from = -1, to = -1;  ///< numbers of the primitives that its ends lie on
  Point from_normal{};     ///< of `from`, on the side that the ray leaves to
};

struct ExactCrossing {
  double t;
  double slack_t;  ///< how far off t may be
  bool sure;       ///< or near a border
  bool on_edge;    ///< near an edge to a neighbour: the hit may be on either
  int primitive;
};

struct ExactAnswer {
  std::vector<ExactCrossing> crossings;
  bool sure() const {
    return std::ranges::any_of(crossings, [](const auto& c) { return c.sure; });
  }
};

/// Primitives, about the scene's origin.  Triangles that have two corners in common are
/// neighbours: a ray between them meets one of both, however near to the edge it passes.
class ExactGeometry {
 public:
  /// `largest`: coordinate of the scene [m], of which vertices are rounded.
  explicit ExactGeometry(double largest) : rounding_(largest * kFloatRoundoff) {}

  /// What is added from here on is an instance, whose rays are taken into its space in floats: its
  /// surface is known less well by this [m].
  void begin_instance(double error) { instance_error_ = error; }

  void triangle(const Point& a, const Point& b, const Point& c) {
    Primitive p{.kind = Kind::kTriangle, .at = {a, b, c, {}}};
    const Point n = cross(b - a, c - a);
    p.normal = normalized(n);
    const double ab = length(b - a), bc = length(c - b), ca = length(a - c);
    // As server/scene_hit.cpp has it: in a needle the plane is known less well.
    const double longest = std::max({ab, bc, ca});
    p.slack = std::clamp(ab * bc * ca / longest / length(n), 1.0, 16.0);
    p.shortest = std::min({ab, bc, ca});
    add(p, (a + b + c) / 3.0, longest);
  }
  void sphere(const Point& centre, double radius) {
    add({.kind = Kind::kSphere, .at = {centre, {}, {}, {}}, .radius = radius}, centre, radius);
  }
  /// `normal` unit.
  void disk(const Point& centre, const Point& normal, double radius) {
    add({.kind = Kind::kDisk, .at = {centre, {}, {}, {}}, .normal = normal, .radius = radius},
        centre, radius);
  }
  /// From `centre` by half the height along the unit vector `axis` to both sides.
  void cylinder(const Point& centre, const Point& axis, double radius, double half_height) {
    add({.kind = Kind::kCylinder,
         .at = {centre, {}, {}, {}},
         .normal = axis,
         .radius = radius,
         .half_height = half_height},
        centre, std::hypot(radius, half_height));
  }
  void patch(const Point& p00, const Point& p10, const Point& p01, const Point& p11) {
    Primitive p{.kind = Kind::kPatch, .at = {p00, p10, p01, p11}};
    p.shortest =
        std::min({length(p10 - p00), length(p01 - p00), length(p11 - p01), length(p11 - p10)});
    const Point centre = (p00 + p10 + p01 + p11) / 4.0;
    double reach = 0;
    for (const Point& c : p.at) reach = std::max(reach, length(c - centre));
    add(p, centre, reach);
  }
  int size() const { return static_cast<int>(primitives_.size()); }
  /// Once all are there: who is whose neighbour.
  void finish() {
    using Key = std::tuple<double, double, double>;
    const auto key = [](const Point& p) { return Key{p.x, p.y, p.z}; };
    std::map<std::pair<Key, Key>, std::vector<std::pair<int, int>>> edges;
    for (int i = 0; i < size(); ++i) {
      if (primitives_[i].kind != Kind::kTriangle) continue;
      for (int e = 0; e < 3; ++e) {
        const auto a = key(primitives_[i].at[e]), b = key(primitives_[i].at[(e + 1) % 3]);
        primitives_[i].edge_up[e] = a < b;
        edges[std::minmax(a, b)].emplace_back(i, e);
      }
    }
    for (const auto& [ends, sides] : edges) {
      if (sides.size() != 2) continue;
      for (int k = 0; k < 2; ++k)
        primitives_[sides[k].first].neighbour[sides[k].second] = sides[1 - k].first;
    }
  }

  struct OnSurface {
    Point position, normal;  // unit
  };

  /// A point of primitive `i`: of triangles and patches at the shares `u`, which may lie on their
  /// border.
  OnSurface point(int i, Vec2<double> u) const {
    const Primitive& p = primitives_[i];
    const double turn = 2 * std::numbers::pi * u.y;
    const Frame<double> frame = Frame<double>::around(p.normal);
    const Point around = frame.s * std::cos(turn) + frame.t * std::sin(turn);
    switch (p.kind) {
      case Kind::kTriangle: {
        if (u.x + u.y > 1) u = {1 - u.x, 1 - u.y};
        return {p.at[0] + (p.at[1] - p.at[0]) * u.x + (p.at[2] - p.at[0]) * u.y, p.normal};
      }
      case Kind::kPatch: {
        const Point e = p.at[1] - p.at[0], f = p.at[2] - p.at[0],
                    g = (p.at[3] - p.at[2]) - (p.at[1] - p.at[0]);
        return {p.at[0] + e * u.x + f * u.y + g * (u.x * u.y),
                normalized(cross(e + g * u.y, f + g * u.x))};
      }
      case Kind::kSphere: {
        const double z = 2 * u.x - 1;
        const Point out = p.normal * z + around * std::sqrt(1 - z * z);
        return {p.at[0] + out * p.radius, out};
      }
      case Kind::kDisk:
        return {p.at[0] + around * (p.radius * u.x), p.normal};
      case Kind::kCylinder:
        return {p.at[0] + p.normal * (p.half_height * (2 * u.x - 1)) + around * p.radius, around};
    }
    return {};
  }

  ExactAnswer along(const ExactRay& ray) const {
    ExactAnswer answer;
    const double dd = dot(ray.direction, ray.direction), length_d = std::sqrt(dd);
    const Point w = ray.direction / length_d;
    for (int i = 0; i < size(); ++i) {
      const Primitive& p = primitives_[i];
      const Point to_centre = p.centre - ray.origin;
      const double along = dot(to_centre, w), square = dot(to_centre, to_centre);
      const double off =
          p.reach + 2 * (ray.start_error + ray.end_error + p.error + kFar * rounding_);
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
      // What is left must lie on the way; near its ends nobody knows.
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

 private:
  /// In roundings of a coordinate, more than the traversal's error is.
  static constexpr double kFar = 200;

  enum class Kind : std::uint8_t { kTriangle, kSphere, kDisk, kCylinder, kPatch };
  struct Primitive {
    Kind kind;
    std::array<Point, 4> at{};
    Point normal{0, 0, 1};
    double radius = 0, half_height = 0, slack = 1, shortest = 0;
    std::array<bool, 3> edge_up{};
    std::array<int, 3> neighbour{-1, -1, -1};
    Point centre{};
    double reach = 0, error = 0;
  };
  struct Meeting {
    const ExactRay& ray;
    Point w;  // the direction, unit
    double length_d, error;
    int primitive;
    std::vector<ExactCrossing>& out;

    /// `normal`: unit, there; `plane_error`: how well the surface is known [m].
    void add(double t, const Point& normal, bool sure, double plane_error,
             bool on_edge = false) const {
      const double cosine = std::fabs(dot(normal, w));
      out.push_back(
          {t, plane_error / (length_d * std::max(cosine, 1e-300)), sure, on_edge, primitive});
    }
  };

  void add(Primitive p, const Point& centre, double reach) {
    p.centre = centre, p.reach = reach, p.error = instance_error_;
    primitives_.push_back(p);
  }

  /// Whether a ray leaves a round surface that it starts on outwards.
  static bool is_convex(const Primitive& p, const ExactRay& ray) {
    Point out = ray.origin - p.at[0];
    if (p.kind == Kind::kCylinder) out = out - p.normal * dot(out, p.normal);
    return dot(out, ray.from_normal) > 0;
  }

  /// Of a round surface that an end lies on, leaves out the crossing that is that end; where none
  /// is near it (the end lies at the border) the others are unsure.
  static void drop_nearest(ExactAnswer& answer, std::size_t first, double t) {
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

  enum class Side : std::uint8_t { kFar, kEdge, kBorder };

  /// Where a ray passes edge `e` of a triangle, which it sees from above or below: kEdge near an
  /// edge to a neighbour that is seen from the same side, kBorder near any other.  By Pluecker
  /// coordinates, each edge from the lesser to the greater of its corners, so that two neighbours
  /// see their edge from opposite sides of the same number.
  Side side_of(const Primitive& p, int e, const Meeting& m, double& value) const {
    const Point a = p.at[e] - m.ray.origin, b = p.at[(e + 1) % 3] - m.ray.origin;
    value = p.edge_up[e] ? dot(m.w, cross(a, b)) : -dot(m.w, cross(b, a));
    if (std::fabs(value) > m.error * length(b - a)) return Side::kFar;
    if (p.neighbour[e] < 0) return Side::kBorder;
    const Primitive& other = primitives_[p.neighbour[e]];
    const double facing = dot(p.normal, m.w), facing_other = dot(other.normal, m.w);
    const bool tells = std::min(std::fabs(facing) * p.shortest,
                                std::fabs(facing_other) * other.shortest) > 4 * m.error;
    return facing * facing_other > 0 && tells ? Side::kEdge : Side::kBorder;
  }

  /// Whether a border lies near the ray, which passes near an edge of triangle `i`: of that or of
  /// those that it may pass instead, all around a corner.
  bool is_near_border(int i, const Meeting& m) const {
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

  void meet_triangle(const Primitive& p, const Meeting& m) const {
    std::array<double, 3> values;
    std::array<Side, 3> sides;
    for (int e = 0; e < 3; ++e) sides[e] = side_of(p, e, m, values[e]);
    // Near a corner the three numbers need not agree: the ray may be on any triangle around it.
    const bool at_corner = std::ranges::count(sides, Side::kEdge) >= 2;
    int above = 0, below = 0;
    bool on_edge = false, border = false;
    // A neighbour that is seen more edge-on may be met farther off.
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
    // Of nearly parallel rays the crossing may be anywhere: it is unsure by its slack.
    const double h = dot(p.normal, p.at[0] - m.ray.origin);
    const double plane_error = m.error + (p.slack - 1) * kTraversalBound * p.reach;
    if (std::fabs(facing) < 1e-14) {
      if (std::fabs(h) <= plane_error) m.out.push_back({0, 1e300, false, false, m.primitive});
      return;
    }
    m.add(h / (facing * m.length_d), p.normal, !border,
          plane_error * (std::fabs(facing) / least_facing), on_edge);
  }

  /// A flat surface that one end lies on cannot be met again, unless the other end lies within its
  /// plane: then all of the way may.
  static void meet_end(const Primitive& p, const Meeting& m) {
    const Point other = m.primitive == m.ray.to ? m.ray.origin : m.ray.origin + m.ray.direction;
    if (m.ray.t_max == 1 && std::fabs(dot(p.normal, other - p.at[0])) <= m.error)
      m.out.push_back({0, 1e300, false, false, m.primitive});
  }

  void meet_disk(const Primitive& p, const Meeting& m) const {
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

  void meet_sphere(const Primitive& p, const Meeting& m) const {
    const Point to = p.at[0] - m.ray.origin;
    const double along = dot(to, m.w);
    const double passing = length(to - m.w * along);
    if (passing > p.radius + m.error) return;
    const bool sure = passing < p.radius - m.error;
    const double half = std::sqrt(std::max(0.0, (p.radius - passing) * (p.radius + passing)));
    for (const double d : {along - half, along + half})
      m.add(d / m.length_d, (m.w * d - to) / p.radius, sure, m.error);
  }

  void meet_cylinder(const Primitive& p, const Meeting& m) const {
    const Point to = p.at[0] - m.ray.origin;
    const Point to_2d = to - p.normal * dot(to, p.normal),
                w_2d = m.w - p.normal * dot(m.w, p.normal);
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

  // The patch cut by two planes that hold the ray: two bilinear equations
  // (Ramsey, Potter, Hansen 2004).
  static void meet_patch(const Primitive& p, const Meeting& m) {
    const Frame<double> frame = Frame<double>::around(m.w);
    const Point e = p.at[1] - p.at[0], f = p.at[2] - p.at[0],
                g = (p.at[3] - p.at[2]) - (p.at[1] - p.at[0]), to = p.at[0] - m.ray.origin;
    const double a1 = dot(frame.s, g), b1 = dot(frame.s, e), c1 = dot(frame.s, f),
                 d1 = dot(frame.s, to);
    const double a2 = dot(frame.t, g), b2 = dot(frame.t, e), c2 = dot(frame.t, f),
                 d2 = dot(frame.t, to);
    const double qa = b1 * a2 - b2 * a1, qb = b1 * c2 + d1 * a2 - b2 * c1 - d2 * a1,
                 qc = d1 * c2 - d2 * c1;
    double discriminant = qb * qb - 4 * qa * qc;
    // Where the two are nearly one the ray passes the silhouette, of which no distance is known: as
    // near as a shift by the error may move it.
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

  double rounding_, instance_error_ = 0;
  std::vector<Primitive> primitives_;
};

}  // namespace lucerna::testing

#include "server/rays/curve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lucerna {
namespace {

using Controls = std::array<Vec3, 4>;

/// Neighbouring pieces overlap by this, so that no ray passes between them.
constexpr double kOverlap = 1e-9;

Vec3 mix(const Vec3& a, const Vec3& b, double u) { return a * (1 - u) + b * u; }

/// The two halves of a Bezier curve.
std::pair<Controls, Controls> halves(const Controls& p) {
  const Vec3 a = (p[0] + p[1]) * 0.5, b = (p[1] + p[2]) * 0.5, c = (p[2] + p[3]) * 0.5;
  const Vec3 ab = (a + b) * 0.5, bc = (b + c) * 0.5, middle = (ab + bc) * 0.5;
  return {{p[0], a, ab, middle}, {middle, bc, c, p[3]}};
}

/// A unit vector between two others, by even turns.
Vec3 turned(const Vec3& a, const Vec3& b, double u) {
  const double angle = 2 * std::atan2(length(b - a), length(b + a));
  const double sine = std::sin(angle);
  if (!(sine > 1e-6)) return normalized(mix(a, b, u));
  return a * (std::sin((1 - u) * angle) / sine) + b * (std::sin(u * angle) / sine);
}

/// Finds the nearest hit of one ray.  Lengths along the ray are in metres.
class Search {
 public:
  Search(const CurvePiece& curve, const Vec3& origin, const Vec3& direction, double from, double to)
      : curve_(curve), o_(origin), d_(direction), from_(from), to_(to) {
    // Two axes across the ray.  The first is away from its largest component.
    const Vec3 away = std::fabs(d_.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    x_ = normalized(cross(d_, away));
    y_ = cross(d_, x_);
  }

  struct Hit {
    double along = 0, u = 0, aside = 0;  ///< aside: of the axis, -1 to 1
    Vec3 position, normal;
  };

  std::optional<Hit> run() {
    Controls p;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 v = curve_.points[i] - o_;
      p[i] = {dot(v, x_), dot(v, y_), dot(v, d_)};
    }
    divide(p, 0, 1, 0);
    return best_;
  }

 private:
  /// `p`: the part of the curve from u0 to u1, in the frame of the ray.
  void divide(const Controls& p, double u0, double u1, int depth) {
    const double reach = std::max(curve_.radius_m(u0), curve_.radius_m(u1)) * (1 + kOverlap);
    const auto outside = [&](auto axis, double low, double high) {
      const auto [least, most] = std::minmax({axis(p[0]), axis(p[1]), axis(p[2]), axis(p[3])});
      return least > high + reach || most < low - reach;
    };
    if (outside([](const Vec3& v) { return v.x; }, 0, 0) ||
        outside([](const Vec3& v) { return v.y; }, 0, 0) ||
        outside([](const Vec3& v) { return v.z; }, from_, best_ ? best_->along : to_))
      return;
    // Second differences bound how much the curve bends across the ray.
    const auto size = [](const Vec3& v) { return std::hypot(v.x, v.y); };
    const double bend = std::max(size(p[0] - p[1] * 2.0 + p[2]), size(p[1] - p[2] * 2.0 + p[3]));
    constexpr int kDeepest = 6;
    if (depth == kDeepest || bend <= 0.25 * size(p[3] - p[0]) || bend <= 0.05 * reach)
      return try_part(p, u0, u1);
    const auto [first, second] = halves(p);
    const double middle = (u0 + u1) / 2;
    divide(first, u0, middle, depth + 1);
    divide(second, middle, u1, depth + 1);
  }

  /// The parameter where the axis is nearest to the ray, by Newton's method.
  std::optional<double> nearest(const Controls& p, double u0, double u1) const {
    const double dx = p[3].x - p[0].x, dy = p[3].y - p[0].y;
    const double chord2 = dx * dx + dy * dy;
    const double share =
        chord2 > 0 ? std::clamp(-(p[0].x * dx + p[0].y * dy) / chord2, 0.0, 1.0) : 0.5;
    double u = u0 + (u1 - u0) * share;
    for (int i = 0; i < 12; ++i) {
      const Vec3 v = across_ray(curve_.at(u) - o_), slope = across_ray(curve_.derivative(u));
      const Vec3 second = across_ray(second_derivative(u));
      const double slope2 = dot(slope, slope);
      if (!(slope2 > 0)) return std::nullopt;  // the ray runs along the axis
      const double whole = slope2 + dot(v, second);
      const double step = dot(v, slope) / (whole > 0.1 * slope2 ? whole : slope2);
      const double to = std::clamp(u - step, 2 * u0 - u1, 2 * u1 - u0);
      if (std::fabs(to - u) < 1e-14) return to;
      u = to;
    }
    return u;
  }

  void try_part(const Controls& p, double u0, double u1) {
    const std::optional<double> u = nearest(p, u0, u1);
    if (!u) return;
    if (curve_.kind != CurveKind::kRibbon) {
      const Vec3 axis = curve_.at(*u);
      const double along = dot(axis - o_, d_);
      const Vec3 position = o_ + d_ * along, from = position - axis;
      if (dot(from, from) > radius2(*u)) return;
      const Vec3 tangent = normalized(curve_.derivative(*u));
      const Vec3 facing = -normalized(d_ - tangent * dot(d_, tangent));
      return keep(*u, along, position, facing);
    }
    // Finds the u whose cross-section contains the hit, by the secant method.
    double before = 0, slip_before = 0, now = *u;
    for (int i = 0; i < 16; ++i) {
      const std::optional<Section> section = at_section(now);
      if (!section) return;
      if (std::fabs(section->slip) <= 1e-9 * curve_.radius_m(now))
        return keep(now, section->along, section->position, section->normal);
      double step = section->slip / length(curve_.derivative(now));
      if (i > 0 && section->slip != slip_before)
        step = -section->slip * (now - before) / (section->slip - slip_before);
      before = now, slip_before = section->slip;
      now = std::clamp(now + step, -1.0, 2.0);
    }
  }

  /// The hit of the ray with the surface if the axis were straight at u.
  struct Section {
    double along;
    Vec3 position, normal;
    double slip;  ///< of the hit along the axis, from the point at u
  };
  std::optional<Section> at_section(double u) const {
    const Vec3 axis = curve_.at(u), tangent = normalized(curve_.derivative(u));
    const double near = dot(axis - o_, d_);
    const Vec3 from_axis = o_ + d_ * near - axis;  // small numbers, so that nothing cancels
    const Vec3 up = turned(Vec3(curve_.normals[0]), Vec3(curve_.normals[1]), u);
    const Vec3 normal = normalized(up - tangent * dot(up, tangent));
    const double facing = dot(d_, normal);
    if (!(std::fabs(facing) > 1e-9)) return std::nullopt;  // from the side
    const double further = -dot(from_axis, normal) / facing;
    const Vec3 from = from_axis + d_ * further;
    return Section{near + further, axis + from, normal, dot(from, tangent)};
  }

  void keep(double u, double along, const Vec3& position, const Vec3& normal) {
    if (u < -kOverlap || u > 1 + kOverlap) return;
    const Vec3 from = position - curve_.at(u);
    if (curve_.kind == CurveKind::kRibbon && dot(from, from) > radius2(u)) return;
    if (!(along > from_ && along < (best_ ? best_->along : to_))) return;
    const Vec3 side = cross(normalized(curve_.derivative(u)), normal);
    const double radius = curve_.radius_m(u);
    const double aside = radius > 0 ? std::clamp(dot(from, side) / radius, -1.0, 1.0) : 0;
    best_ = Hit{along, std::clamp(u, 0.0, 1.0), aside, position, normal};
    if (curve_.kind != CurveKind::kCylinder) return;
    // The angle of the normal grows evenly over the width, to a right angle at the edges.
    const double angle = kPi / 2 * aside;
    best_->normal = normal * std::cos(angle) - side * std::sin(angle);
  }

  double radius2(double u) const { return curve_.radius_m(u) * curve_.radius_m(u); }
  Vec3 across_ray(const Vec3& v) const { return v - d_ * dot(v, d_); }
  Vec3 second_derivative(double u) const {
    const Controls& p = curve_.points;
    return mix(p[0] - p[1] * 2.0 + p[2], p[1] - p[2] * 2.0 + p[3], u) * 6.0;
  }

  const CurvePiece& curve_;
  Vec3 o_, d_, x_, y_;
  double from_, to_;
  std::optional<Hit> best_;
};

}  // namespace

Vec3 CurvePiece::at(double u) const {
  const Vec3 a = mix(points[0], points[1], u), b = mix(points[1], points[2], u),
             c = mix(points[2], points[3], u);
  return mix(mix(a, b, u), mix(b, c, u), u);
}

Vec3 CurvePiece::derivative(double u) const {
  const Vec3 a = points[1] - points[0], b = points[2] - points[1], c = points[3] - points[2];
  const Vec3 tangent = mix(mix(a, b, u), mix(b, c, u), u) * 3.0;
  // Control points that coincide at an end: the direction to the next one.
  return tangent == Vec3{} ? points[3] - points[0] : tangent;
}

std::optional<ShapeHit> CurvePiece::intersect(const Vec3& origin, const Vec3& direction,
                                              double t_min, double t_max, Vec2* uv_hit) const {
  const double metres = length(direction);
  const auto hit = Search(*this, origin, direction / metres, t_min * metres, t_max * metres).run();
  if (!hit) return std::nullopt;
  if (uv_hit != nullptr) *uv_hit = {hit->u, (1 + hit->aside) / 2};
  ShapeHit result;
  result.t = hit->along / metres;
  result.point.position = hit->position;
  result.point.normal = hit->normal;
  return result;
}

std::pair<Vec3, Vec3> CurvePiece::bounds() const {
  const double r = std::max(start_radius_m, end_radius_m);
  Vec3 lower = points[0], upper = points[0];
  for (const Vec3& p : points) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  return {lower - Vec3{r, r, r}, upper + Vec3{r, r, r}};
}

double CurvePiece::hit_error_m(double u) const {
  // The search for a ribbon ends within 1e-9 radii along the axis.  1e-8 allows for a bent axis.
  return radius_m(u) * (kind == CurveKind::kRibbon ? 1e-8 : 1);
}

std::vector<CurvePiece> pieces_of(const CubicCurve& curve, CurveKind kind, const Vec3& origin) {
  CurvePiece whole;
  for (std::size_t i = 0; i < 4; ++i) whole.points[i] = curve.points[i] - origin;
  whole.start_radius_m = curve.start_width_m / 2, whole.end_radius_m = curve.end_width_m / 2;
  whole.kind = kind;
  for (std::size_t i = 0; i < 2; ++i) whole.normals[i] = Vec3f(curve.normals[i]);
  double reach = 0;
  for (std::size_t i = 0; i < 3; ++i) reach += length(whole.points[i + 1] - whole.points[i]);
  if (reach <= 8 * std::max(whole.start_radius_m, whole.end_radius_m)) return {whole};
  std::vector<CurvePiece> pieces(4, whole);
  const auto [first, second] = halves(whole.points);
  std::tie(pieces[0].points, pieces[1].points) = halves(first);
  std::tie(pieces[2].points, pieces[3].points) = halves(second);
  for (std::size_t i = 0; i < 4; ++i) {
    const double u0 = double(i) / 4, u1 = double(i + 1) / 4;
    pieces[i].start_radius_m = whole.radius_m(u0), pieces[i].end_radius_m = whole.radius_m(u1);
    if (kind == CurveKind::kRibbon)
      pieces[i].normals = {Vec3f(turned(curve.normals[0], curve.normals[1], u0)),
                           Vec3f(turned(curve.normals[0], curve.normals[1], u1))};
  }
  return pieces;
}

}  // namespace lucerna

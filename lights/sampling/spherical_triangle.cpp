#include "lights/sampling/spherical_triangle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/maths/triple_product.h"

namespace lucerna {

namespace {

double norm(const Vec3& v) { return std::sqrt(dot(v, v)); }

/// The power of two that scales the longest of three vectors to about 1, exactly. 0 where all are 0
/// or one is not finite.
double unit_for(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double largest = std::max({max_abs(a), max_abs(b), max_abs(c)});
  if (!(largest > 0) || !is_finite(a + b + c)) return 0;
  return std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1022, 1022));
}

}  // namespace

double triangle_solid_angle(const Vec3& a, const Vec3& b, const Vec3& c, double determinant) {
  const double la = norm(a);
  const double lb = norm(b);
  const double lc = norm(c);
  return 2 * std::atan2(std::fabs(determinant),
                        la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
}

double triangle_solid_angle(const Vec3& a, const Vec3& ab, const Vec3& ac) {
  // Computed from the edges.  The corners of small triangles are nearly parallel, so their triple
  // product cancels.
  return triangle_solid_angle(a, a + ab, a + ac, dot(a, cross(ab, ac)));
}

std::optional<SphericalTriangle> SphericalTriangle::create(const Vec3& world_a, const Vec3& world_b,
                                                           const Vec3& world_c,
                                                           const Vec3& receiver) {
  const double unit = unit_for(world_a - receiver, world_b - receiver, world_c - receiver);
  if (!(unit > 0)) return std::nullopt;
  const auto to_unit = [unit](const Vec3& v) { return v * unit; };
  return create(to_unit(world_a - receiver), to_unit(world_b - receiver),
                to_unit(world_b - world_a), to_unit(world_c - world_a),
                triple_product_of_corners(to_unit(receiver), to_unit(world_a), to_unit(world_b),
                                          to_unit(world_c)));
}

std::optional<SphericalTriangle> SphericalTriangle::create_seen(const Vec3& a, const Vec3& b,
                                                                const Vec3& c, double determinant) {
  const double unit = unit_for(a, b, c);
  if (!(unit > 0)) return std::nullopt;
  return create(a * unit, b * unit, (b - a) * unit, (c - a) * unit,
                determinant * unit * unit * unit);
}

std::optional<SphericalTriangle> SphericalTriangle::create(const Vec3& a, const Vec3& b,
                                                           const Vec3& ab, const Vec3& ac,
                                                           double determinant) {
  const double la = norm(a);
  const double lb = norm(b);
  if (!(la > 0) || !(lb > 0)) return std::nullopt;
  determinant = std::fabs(determinant);

  SphericalTriangle t;
  t.solid_angle_ = triangle_solid_angle(a, b, a + ac, determinant);
  if (!(t.solid_angle_ > 0 && t.solid_angle_ < kMaxSolidAngle)) return std::nullopt;
  t.unit_a_ = a / la;
  t.unit_b_ = b / lb;
  t.ac_ = ac / la;
  t.ba_ = -(ab / lb);
  t.bisector_ = t.unit_a_ + t.unit_b_;
  t.a_by_b_ = la / lb;
  t.determinant_ = determinant / (la * la * lb);
  return t;
}

double SphericalTriangle::Arc::one_minus_cos(double s) const {
  const double x = 1 + s * cosine;
  const double y = s * sine;
  const double length = std::sqrt(x * x + y * y);
  // sin^2 / (1 + cos), except where 1 + cos cancels.
  return x > 0 ? y / length * (y / (length + x)) : (length - x) / length;
}

SphericalTriangle::Arc SphericalTriangle::arc_to(double t) const {
  const Vec3 m = ba_ + ac_ * (t * a_by_b_);
  return {norm(cross(unit_b_, m)), dot(unit_b_, m)};
}

Vec3 SphericalTriangle::sample(Vec2 u) const {
  // c' = a + t (c - a) cuts off a triangle (a, b, c') of solid angle u.x times the whole.  Lengths
  // are in units of |a|, A and B are unit vectors, E = (c - a) / |a|, and w is half of that solid
  // angle.  [Oosterom83] gives
  //   tan w = t det(A, B, E) / ((1 + A.B) (1 + |A + t E|) + t (A + B).E).
  // Squaring removes the root and leaves an equation linear in t.  It uses sine and cosine of w,
  // since w may exceed pi / 2.  (Arvo solves for the direction of c' instead, by angles that cancel
  // in small triangles.)
  const double w = u.x * solid_angle_ / 2;
  const double p = std::cos(w) * determinant_ - std::sin(w) * dot(bisector_, ac_);
  const double q = std::sin(w) * dot(bisector_, bisector_) / 2;
  const double q_edge = q * norm(ac_);
  const double t = clamp_unit(2 * q * (p + q * dot(unit_a_, ac_)) / ((p - q_edge) * (p + q_edge)));

  // Along the arc from b to c', 1 - cos of the angle from b is uniform.
  const Arc arc = arc_to(t);
  const double h = clamp_unit(u.y) * arc.one_minus_cos(1);
  const double sine = std::sqrt(h * (2 - h));
  const double s = clamp_unit(sine / (arc.sine * (1 - h) - sine * arc.cosine));
  return {s * (1 - t), 1 - s, s * t};
}

Vec2 SphericalTriangle::invert(const Vec3& barycentric) const {
  const double s = clamp_unit(barycentric.x + barycentric.z);
  const double t = s > 0 ? clamp_unit(barycentric.z / s) : 0;
  const double one_plus_cos = dot(bisector_, bisector_) / 2;
  const double part =
      2 * std::atan2(t * determinant_,
                     one_plus_cos * (1 + norm(unit_a_ + ac_ * t)) + t * dot(bisector_, ac_));
  const Arc arc = arc_to(t);
  return {clamp_unit(part / solid_angle_), clamp_unit(arc.one_minus_cos(s) / arc.one_minus_cos(1))};
}

}  // namespace lucerna

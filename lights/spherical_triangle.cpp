#include "lights/spherical_triangle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lucerna {

namespace {

/// Beyond this a triangle covers the hemisphere: its edges lie in the receiver's horizon to within
/// the rounding of what follows.
constexpr double kMaxSolidAngle = 2 * std::numbers::pi - 1e-6;

double norm(const Vec3<double>& v) { return std::sqrt(dot(v, v)); }

/// Also for what rounding makes of a fraction between equals.
double clamp_unit(double x) { return std::fmin(std::fmax(x, 0), 1); }

}  // namespace

double triangle_solid_angle(const Vec3<double>& a, const Vec3<double>& ab, const Vec3<double>& ac) {
  const Vec3<double> b = a + ab;
  const Vec3<double> c = a + ac;
  const double la = norm(a);
  const double lb = norm(b);
  const double lc = norm(c);
  // By the edges: for small triangles the corners are parallel, and their own product cancels.
  const double determinant = std::fabs(dot(a, cross(ab, ac)));
  return 2 *
         std::atan2(determinant, la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
}

std::optional<SphericalTriangle> SphericalTriangle::create(const Vec3<double>& world_a,
                                                           const Vec3<double>& world_b,
                                                           const Vec3<double>& world_c) {
  const double largest = std::max({max_abs(world_a), max_abs(world_b), max_abs(world_c)});
  if (!(largest > 0) || !std::isfinite(largest)) return std::nullopt;
  const int exponent = -std::ilogb(largest);
  const Vec3<double> a = scaled(world_a, exponent);
  const Vec3<double> b = scaled(world_b, exponent);
  const Vec3<double> c = scaled(world_c, exponent);
  const double la = norm(a);
  const double lb = norm(b);
  if (!(la > 0) || !(lb > 0)) return std::nullopt;
  const Vec3<double> ab = b - a;
  const Vec3<double> ac = c - a;

  SphericalTriangle t;
  t.solid_angle_ = triangle_solid_angle(a, ab, ac);
  if (!(t.solid_angle_ > 0 && t.solid_angle_ < kMaxSolidAngle)) return std::nullopt;
  t.unit_a_ = a / la;
  t.unit_b_ = b / lb;
  t.ac_ = ac / la;
  t.ba_ = -(ab / lb);
  t.bisector_ = t.unit_a_ + t.unit_b_;
  t.a_by_b_ = la / lb;
  t.determinant_ = std::fabs(dot(a, cross(ab, ac))) / (la * la * lb);
  return t;
}

double SphericalTriangle::Arc::one_minus_cos(double s) const {
  const double x = 1 + s * cosine;
  const double y = s * sine;
  const double length = std::sqrt(x * x + y * y);
  // sin^2 / (1 + cos), unless it is 1 + cos that cancels.
  return x > 0 ? y / length * (y / (length + x)) : (length - x) / length;
}

SphericalTriangle::Arc SphericalTriangle::arc_to(double t) const {
  const Vec3<double> m = ba_ + ac_ * (t * a_by_b_);
  return {norm(cross(unit_b_, m)), dot(unit_b_, m)};
}

Vec3<double> SphericalTriangle::sample(Vec2<double> u) const {
  // c' = a + t (c - a) cuts off a triangle (a, b, c') of solid angle u.x times the whole.  In units
  // of |a|, with A, B unit, E = (c - a) / |a| and w half of that solid angle, [Oosterom83] says
  //   tan w = t det(A, B, E) / ((1 + A.B) (1 + |A + t E|) + t (A + B).E),
  // and squared, to be rid of the root, what is left is linear in t.  Written with sine and cosine
  // of w, which may be beyond pi / 2.  (Arvo solves for the direction of c' instead, by angles that
  // cancel in small triangles.)
  const double w = u.x * solid_angle_ / 2;
  const double p = std::cos(w) * determinant_ - std::sin(w) * dot(bisector_, ac_);
  const double q = std::sin(w) * dot(bisector_, bisector_) / 2;
  const double q_edge = q * norm(ac_);
  const double t = clamp_unit(2 * q * (p + q * dot(unit_a_, ac_)) / ((p - q_edge) * (p + q_edge)));

  // Along the arc from b to c', 1 - cos of the way from b is uniform.
  const Arc arc = arc_to(t);
  const double h = clamp_unit(u.y) * arc.one_minus_cos(1);
  const double sine = std::sqrt(h * (2 - h));
  const double s = clamp_unit(sine / (arc.sine * (1 - h) - sine * arc.cosine));
  return {s * (1 - t), 1 - s, s * t};
}

Vec2<double> SphericalTriangle::invert(const Vec3<double>& barycentric) const {
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

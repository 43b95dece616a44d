#include "lights/sampling/spherical_rectangle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/maths/turn.h"
#include "lights/sampling/spherical_triangle.h"

namespace lucerna {

namespace {

constexpr double kMinSolidAngle = 1e-5;

/// A complex number: an angle, times any positive factor.
struct Turn {
  double cos, sin;
  Turn plus(const Turn& other) const {
    return {cos * other.cos - sin * other.sin, sin * other.cos + cos * other.sin};
  }
  Turn less(const Turn& other) const {
    return {cos * other.cos + sin * other.sin, sin * other.cos - cos * other.sin};
  }
};

/// `v` between `from` and `to`; `from` for NaN.
double between(double v, double from, double to) {
  const double least = v > from ? v : from;
  return least < to ? least : to;
}
double unit(double v) { return between(v, 0, 1); }

}  // namespace

std::optional<SphericalRectangle> SphericalRectangle::create(const Vec3& corner, const Vec3& edge_x,
                                                             const Vec3& edge_y) {
  return create(corner, edge_x, edge_y, dot(corner, cross(normalized(edge_x), normalized(edge_y))));
}

std::optional<SphericalRectangle> SphericalRectangle::create(const Vec3& corner, const Vec3& edge_x,
                                                             const Vec3& edge_y, double height) {
  const double largest = std::max({max_abs(corner), max_abs(edge_x), max_abs(edge_y)});
  if (!(largest > 0) || !std::isfinite(largest)) return std::nullopt;
  const int exponent = -exponent_of(largest);
  const Vec3 p = scaled(corner, exponent);
  const Vec3 ex = scaled(edge_x, exponent);
  const Vec3 ey = scaled(edge_y, exponent);
  const double dx = length(ex), dy = length(ey);

  SphericalRectangle r;
  r.z_ = std::fabs(scaled(height, exponent));
  if (!(r.z_ > 0)) return std::nullopt;
  r.x0_ = dot(p, ex) / dx;
  r.x1_ = r.x0_ + dx;
  r.y0_ = dot(p, ey) / dy;
  r.y1_ = r.y0_ + dy;

  // Both halves by [Oosterom83], in the frame of the rectangle.  The corners are 00, 10, 01 and 11.
  const double z2 = r.z_ * r.z_;
  const double xx0 = r.x0_ * r.x0_, xx = r.x0_ * r.x1_, xx1 = r.x1_ * r.x1_;
  const double yy0 = r.y0_ * r.y0_, yy = r.y0_ * r.y1_, yy1 = r.y1_ * r.y1_;
  const double l00 = std::sqrt(xx0 + yy0 + z2), l10 = std::sqrt(xx1 + yy0 + z2);
  const double l01 = std::sqrt(xx0 + yy1 + z2), l11 = std::sqrt(xx1 + yy1 + z2);
  const double determinant = r.z_ * dx * dy;  // of either half
  const double diagonal = l10 * l01 + (xx + yy + z2);
  const Turn first{l00 * diagonal + (xx + yy0 + z2) * l01 + (xx0 + yy + z2) * l10, determinant};
  const Turn second{l11 * diagonal + (xx + yy1 + z2) * l10 + (xx1 + yy + z2) * l01, determinant};
  const Turn half = first.plus(second);
  r.solid_angle_ = 2 * std::atan2(half.sin, half.cos);
  if (!(r.solid_angle_ >= kMinSolidAngle && r.solid_angle_ <= kMaxSolidAngle)) return std::nullopt;
  r.distance00_ = l00;
  r.distance01_ = l01;
  return r;
}

double SphericalRectangle::strip(double x) const {
  const auto corner = [&](double y) {
    return std::atan2(x * y, z_ * std::sqrt(x * x + y * y + z_ * z_));
  };
  return corner(y1_) - corner(y0_);
}

Vec2 SphericalRectangle::sample(Vec2 u) const {
  // The strip between 0 and x covers d = asin(k1 s) - asin(k0 s).  Here s = sin phi, tan phi = x /
  // z, and k0 and k1 are the sines of the elevations of the edges.  The law of cosines then gives
  // s^2 (k1^2 + k0^2 - 2 k1 k0 cos d) = sin^2 d.
  const double share = unit(u.x);
  const CosSin part = cos_sin_of_turn(share * (solid_angle_ * (0.5 / kPi)));
  const Turn before = Turn{z_ * distance01_, x0_ * y1_}.less({z_ * distance00_, x0_ * y0_});
  const Turn sum = before.plus({part.cos, part.sin});
  const double to_unit = 1 / std::sqrt(before.cos * before.cos + before.sin * before.sin);
  const double sin_d = sum.sin * to_unit, cos_d = sum.cos * to_unit;
  // Sines of the elevations without their signs, and squares of their cosines.  From these come
  // differences that would cancel for a receiver near the plane.
  const double per_rho0 = 1 / (y0_ * y0_ + z_ * z_), per_rho1 = 1 / (y1_ * y1_ + z_ * z_);
  const double k0 = std::fabs(y0_) * std::sqrt(per_rho0), k1 = std::fabs(y1_) * std::sqrt(per_rho1);
  const double e0 = z_ * z_ * per_rho0, e1 = z_ * z_ * per_rho1;
  const double outer =  // |k1| - |k0|
      z_ * z_ * (y1_ - y0_) * (y1_ + y0_) * per_rho0 * per_rho1 / (k0 + k1);
  const double one_minus_kk = (e0 + e1 - e0 * e1) / (1 + k0 * k1);
  const double c = (y0_ > 0) == (y1_ > 0) ? cos_d : -cos_d;
  const double one_minus_c = c > 0 ? sin_d * sin_d / (1 + c) : 1 - c;
  // sin^2 d / tan^2 phi
  const double rest = outer * outer + one_minus_c * (one_minus_c - 2 * one_minus_kk);
  // x loses digits where phi is nearly a right angle, but both ends are exact.
  const double x = between(z_ * sin_d / std::sqrt(rest > 0 ? rest : 0), share < 1 ? x0_ : x1_,
                           share > 0 ? x1_ : x0_);

  // At this x, the sine of the elevation along y is uniform.
  const double r2 = x * x + z_ * z_;
  const double h0 = y0_ / std::sqrt(r2 + y0_ * y0_);
  const double h1 = y1_ / std::sqrt(r2 + y1_ * y1_);
  const double h = h0 + unit(u.y) * (h1 - h0);
  const double y = h * std::sqrt(r2 / ((1 - h) * (1 + h)));
  return {unit((x - x0_) * (1 / (x1_ - x0_))), unit((y - y0_) * (1 / (y1_ - y0_)))};
}

Vec2 SphericalRectangle::invert(Vec2 shares) const {
  const double x = x0_ + shares.x * (x1_ - x0_);
  const double y = y0_ + shares.y * (y1_ - y0_);
  const double r = std::sqrt(x * x + z_ * z_);
  const auto elevation = [r](double y) { return y / std::sqrt(r * r + y * y); };
  return {unit((strip(x) - strip(x0_)) / solid_angle_),
          unit((elevation(y) - elevation(y0_)) / (elevation(y1_) - elevation(y0_)))};
}

}  // namespace lucerna

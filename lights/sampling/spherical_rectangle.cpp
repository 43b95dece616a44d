#include "lights/sampling/spherical_rectangle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/sampling/spherical_triangle.h"

namespace lucerna {

namespace {

constexpr double kMinSolidAngle = 1e-5;

}  // namespace

std::optional<SphericalRectangle> SphericalRectangle::create(const Vec3<double>& corner,
                                                             const Vec3<double>& edge_x,
                                                             const Vec3<double>& edge_y) {
  return create(corner, edge_x, edge_y, dot(corner, cross(normalized(edge_x), normalized(edge_y))));
}

std::optional<SphericalRectangle> SphericalRectangle::create(const Vec3<double>& corner,
                                                             const Vec3<double>& edge_x,
                                                             const Vec3<double>& edge_y,
                                                             double height) {
  const double largest = std::max({max_abs(corner), max_abs(edge_x), max_abs(edge_y)});
  if (!(largest > 0) || !std::isfinite(largest)) return std::nullopt;
  const int exponent = -std::ilogb(largest);
  const Vec3<double> p = scaled(corner, exponent);
  const Vec3<double> ex = scaled(edge_x, exponent);
  const Vec3<double> ey = scaled(edge_y, exponent);
  const double dx = length(ex), dy = length(ey);

  SphericalRectangle r;
  r.z_ = std::fabs(std::scalbn(height, exponent));
  if (!(r.z_ > 0)) return std::nullopt;
  const double determinant = r.z_ * dx * dy;  // of either half
  r.solid_angle_ = triangle_solid_angle(p, p + ex, p + ey, determinant) +
                   triangle_solid_angle(p + ex + ey, p + ey, p + ex, determinant);
  if (!(r.solid_angle_ >= kMinSolidAngle && r.solid_angle_ <= kMaxSolidAngle)) return std::nullopt;
  const Vec3<double> x = ex / dx;
  const Vec3<double> y = ey / dy;
  r.x0_ = dot(p, x);
  r.x1_ = r.x0_ + dx;
  r.y0_ = dot(p, y);
  r.y1_ = r.y0_ + dy;
  r.sin_y0_ = r.y0_ / std::sqrt(r.y0_ * r.y0_ + r.z_ * r.z_);
  r.sin_y1_ = r.y1_ / std::sqrt(r.y1_ * r.y1_ + r.z_ * r.z_);
  r.strip_x0_ = r.strip(r.x0_);
  return r;
}

double SphericalRectangle::strip(double x) const {
  const auto corner = [&](double y) {
    return std::atan2(x * y, z_ * std::sqrt(x * x + y * y + z_ * z_));
  };
  return corner(y1_) - corner(y0_);
}

Vec2<double> SphericalRectangle::sample(Vec2<double> u) const {
  // The strip between 0 and x covers d = asin(k1 s) - asin(k0 s).  Here s = sin phi, tan phi = x /
  // z, and k0 and k1 are the sines of the elevations of the edges.  The law of cosines then gives
  // s^2 (k1^2 + k0^2 - 2 k1 k0 cos d) = sin^2 d.
  const double d = strip_x0_ + clamp_unit(u.x) * solid_angle_;
  const double k0 = sin_y0_;
  const double k1 = sin_y1_;
  const double half = k0 * k1 > 0 ? std::sin(d / 2) : std::cos(d / 2);
  const double outer = k0 * k1 > 0 ? k1 - k0 : k1 + k0;
  const double k = std::sqrt(outer * outer + 4 * std::fabs(k0 * k1) * half * half);
  const double sin_phi = std::clamp(std::sin(d) / k, -1.0, 1.0);
  const double cos_phi = std::sqrt((1 - sin_phi) * (1 + sin_phi));
  const double x = std::fmin(std::fmax(z_ * sin_phi / cos_phi, x0_), x1_);

  // At this x, the sine of the elevation along y is uniform.
  const double r = std::sqrt(x * x + z_ * z_);
  const double h0 = y0_ / std::sqrt(r * r + y0_ * y0_);
  const double h1 = y1_ / std::sqrt(r * r + y1_ * y1_);
  const double h = h0 + clamp_unit(u.y) * (h1 - h0);
  const double y = r * h / std::sqrt((1 - h) * (1 + h));
  return {clamp_unit((x - x0_) / (x1_ - x0_)), clamp_unit((y - y0_) / (y1_ - y0_))};
}

Vec2<double> SphericalRectangle::invert(Vec2<double> shares) const {
  const double x = x0_ + shares.x * (x1_ - x0_);
  const double y = y0_ + shares.y * (y1_ - y0_);
  const double r = std::sqrt(x * x + z_ * z_);
  const auto elevation = [r](double y) { return y / std::sqrt(r * r + y * y); };
  return {clamp_unit((strip(x) - strip_x0_) / solid_angle_),
          clamp_unit((elevation(y) - elevation(y0_)) / (elevation(y1_) - elevation(y0_)))};
}

}  // namespace lucerna

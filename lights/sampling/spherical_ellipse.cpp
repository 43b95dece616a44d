#include "lights/sampling/spherical_ellipse.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lights/sampling/sampling.h"

namespace lucerna {

std::optional<SphericalEllipse> SphericalEllipse::create(double offset, double height,
                                                         double radius) {
  constexpr double kLeast = 1e-5;
  const double largest = std::fmax(offset, std::fmax(height, radius));
  if (!(height > 0) || !(radius > 0) || !std::isfinite(largest)) return std::nullopt;
  SphericalEllipse e;
  e.exponent_ = std::ilogb(largest);
  const double d = std::scalbn(offset, -e.exponent_);
  const double h = e.height_ = std::scalbn(height, -e.exponent_);
  const double r = e.radius_ = std::scalbn(radius, -e.exponent_);

  // l0 and l1 are the distances to the nearest and farthest points of the rim.  These points, the
  // receiver and the bisector give, with q = l0 l1 cos(2 beta) and 2 r h = l0 l1 sin(2 beta):
  //   sin alpha = 2 r / (l0 + l1),   cos^2 beta = ((l0 + l1)^2 - 4 r^2) / (4 l0 l1).
  // The bisector meets the disk's plane at d cos^2 alpha, at a distance of sqrt(l0 l1) cos alpha.
  // Also, (l0 + l1)^2 - 4 r^2 = 2 (l0 l1 + q).  One of l0 l1 + q and l0 l1 - q cancels.  It follows
  // from the other one and their product, (2 r h)^2.
  const double q = (d - r) * (d + r) + h * h;
  const double rh = 2 * r * h;
  const double product = std::sqrt(q * q + rh * rh);
  const double plus = q >= 0 ? product + q : rh * rh / (product - q);
  const double minus = q >= 0 ? rh * rh / (product + q) : product - q;
  const double squared_sum = 2 * (d * d + r * r + h * h + product);
  e.sin_alpha_ = 2 * r / std::sqrt(squared_sum);
  e.cos_alpha_ = std::sqrt(2 * plus / squared_sum);
  e.sin_beta_ = std::sqrt(minus / (2 * product));
  e.cos_beta_ = std::sqrt(plus / (2 * product));
  // For a receiver close to the disk but not near its rim, the whole edge is at the horizon.
  constexpr double kHorizon = 1e-3;
  if (!(e.sin_beta_ >= kLeast) || !(e.cos_alpha_ >= kLeast || e.cos_beta_ <= kHorizon) ||
      !(e.cos_alpha_ > 0))
    return std::nullopt;
  e.to_axis_ = std::sqrt(product) * e.cos_alpha_;
  e.axis_ = -d * e.sin_alpha_ * e.sin_alpha_;
  e.foot_axis_ = d * e.cos_alpha_ * e.cos_alpha_;
  e.cos_tilt_ = h / e.to_axis_;
  e.sin_tilt_ = d * e.cos_alpha_ / std::sqrt(product);
  return e;
}

double SphericalEllipse::squared_edge(double x, double y) const {
  const double rr = x * x + y * y;
  // The middle is on all meridians.  Use the meridian of the long axis.
  if (!(rr > 0)) return cos_alpha_ * cos_alpha_;
  return (cos_alpha_ * cos_alpha_ * x * x + cos_beta_ * cos_beta_ * y * y) / rr;
}

SphericalEllipse::Point SphericalEllipse::choose(Vec2 u) const {
  // (x, y) = sqrt(s) (cos t, sin t), where s = (1 - cos) / (1 - n) and t are uniform.
  const auto [x, y] = sample_concentric_disk(u);
  const double n = std::sqrt(squared_edge(x, y));
  const double across = sin_alpha_ * x;
  const double along = sin_beta_ * y;
  // across^2 + along^2 = s (1 - n^2).
  const double one_minus_cos = (across * across + along * along) / (1 + n);
  const double stretch = std::sqrt((2 - one_minus_cos) / (1 + n));
  // Project onto the disk's plane, relative to the point where the middle meets it.  The only
  // difference is in `climb`, where both terms are as small as the result.
  const double climb = (1 - one_minus_cos) * cos_tilt_ - along * stretch * sin_tilt_;
  const double from_axis = to_axis_ * along * stretch / climb;
  const double aside = height_ * across * stretch / climb;
  Vec2 p{axis_ + from_axis, aside};
  const double distance = std::sqrt(p.x * p.x + p.y * p.y);
  if (!(distance <= radius_)) p = {p.x * (radius_ / distance), p.y * (radius_ / distance)};
  return {{std::scalbn(p.x, exponent_), std::scalbn(p.y, exponent_)},
          {std::scalbn(foot_axis_ + from_axis, exponent_), std::scalbn(aside, exponent_)}};
}

double SphericalEllipse::pdf(Vec2 point) const {
  const double x = std::scalbn(point.y, -exponent_) / sin_alpha_;
  const double y = (std::scalbn(point.x, -exponent_) - axis_) * cos_tilt_ / sin_beta_;
  const double n = std::sqrt(squared_edge(x, y));
  return (1 + n) / (2 * std::numbers::pi * sin_alpha_ * sin_beta_);
}

}  // namespace lucerna

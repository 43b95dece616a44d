#include "lights/sampling/spherical_fan.h"

#include <algorithm>
#include <cmath>

namespace lucerna {

namespace {

/// The solid angle of the triangle of the foot and an edge at `distance`, from the edge's nearest
/// point to `y`.  It combines sine and cosine of phi and of asin(k sin phi), so nothing cancels.
double covered(double distance, double y, double height) {
  const double rho2 = y * y + distance * distance;
  const double r = std::sqrt(rho2 + height * height);
  return std::atan2(distance * y * (rho2 / (r + height)), distance * distance * r + height * y * y);
}

}  // namespace

std::optional<SphericalFan> SphericalFan::create(std::span<const Vec3> corners, const Vec3& normal,
                                                 double height) {
  if (!is_low(corners, height)) return std::nullopt;
  SphericalFan fan;
  fan.height_ = std::fabs(height);
  fan.to_foot_ = normal * -height;

  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    Edge edge;
    edge.along = normalized(b - a);
    // The distance within the plane does not depend on the height.
    edge.outwards = cross(edge.along, normal);
    edge.distance = dot(a, edge.outwards);
    if (edge.distance == 0) continue;  // the foot is on the edge: the triangle is empty
    if (!(edge.distance > 0)) return std::nullopt;
    edge.from = dot(a, edge.along);
    edge.to = dot(b, edge.along);
    edge.covered_from = covered(edge.distance, edge.from, fan.height_);
    sum += covered(edge.distance, edge.to, fan.height_) - edge.covered_from;
    fan.edge_[fan.count_] = edge;
    fan.up_to_[fan.count_++] = sum;
  }
  if (!(sum > 0)) return std::nullopt;
  return fan;
}

Vec3 SphericalFan::sample(Vec2 u) const {
  const double target = std::clamp(u.x, 0.0, 1.0) * up_to_[count_ - 1];
  int i = 0;
  while (i + 1 < count_ && target > up_to_[i]) ++i;
  const Edge& edge = edge_[i];
  const double d = edge.distance, h = height_;
  const double covered = edge.covered_from + (target - (i == 0 ? 0 : up_to_[i - 1]));
  // cos G - k, from 1 - k and 1 - cos G.
  const double slant = std::sqrt(h * h + d * d);
  const double half = std::sin(covered / 2);
  const double fraction = d * (d / (slant * (slant + h))) - 2 * half * half;
  const double sine = std::sin(covered);
  // Rounding may lead to a right angle or more.  Use the end of the edge then.
  const double y = fraction > 0 ? std::clamp(d * (sine / fraction), edge.from, edge.to)
                                : (sine < 0 ? edge.from : edge.to);

  // On the way to the edge, the cosine to the normal is uniform.
  const double rho = std::sqrt(d * d + y * y);
  const double share = std::clamp(u.y, 0.0, 1.0);
  const double least = h / std::sqrt(rho * rho + h * h);
  const double cosine = (1 - share) + share * least;
  const double sine2 = share * (1 - least) * (1 + cosine);
  const double reach = std::fmin(h * (std::sqrt(sine2) / cosine), rho) / rho;
  return to_foot_ + edge.outwards * (reach * d) + edge.along * (reach * y);
}

}  // namespace lucerna

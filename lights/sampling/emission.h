// Functions that lights share for rays that leave them: the disk where rays from infinity enter the
// scene, and the error of an approximate power.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lights/sampling/light_sample.h"
#include "lights/sampling/sampling.h"

namespace lucerna {

/// A book's formula for a light's power, with its error: the difference from `power`, plus the
/// error of `power`.
inline Power approximate_power(const Rgb<double>& lumens, const Power& power) {
  return {lumens, std::fabs(luminance(lumens - power.lumens)) + power.error_lumens};
}

/// Sets the reason of a sample that was chosen with `density` (of position or of direction).  Value
/// and density belong to the rounded sample.  kOutsideCone if rounding leads out of the light or to
/// a value of 0.  kOutOfRange where the density is not a positive `Real`.
template <std::floating_point Real>
void settle(Real density, EmissionSample<Real>& sample) {
  if (sample.value.is_black()) {
    sample.reason = NoLight::kOutsideCone;
  } else if (!(density > 0 && std::isfinite(density))) {
    sample.reason = NoLight::kOutOfRange;
    sample.value = {};
  }
}

/// Starts a ray along the unit vector `direction` on the disk that faces it, touches the scene's
/// sphere and has its radius.  Sets origin, direction and pdf_position. kDegenerate where the
/// scene's sphere has no extent.  [Pharr23, 12.5]
template <std::floating_point Real>
void start_on_scene_disk(Vec2<Real> u, const Vec3<double>& direction, const SceneSphere& scene,
                         EmissionSample<Real>& sample) {
  const double radius = scene.radius_m;
  sample.direction = Vec3<Real>(direction);
  sample.pdf_position = {static_cast<Real>(concentric_disk_pdf(radius).per_m2)};
  if (!(sample.pdf_position.per_m2 > 0 && std::isfinite(sample.pdf_position.per_m2))) {
    sample.pdf_position = {};
    sample.reason = NoLight::kDegenerate;
    return;
  }
  const Vec2<double> d = sample_concentric_disk(Vec2<double>{u.x, u.y});
  const Vec3<double> local{d.x, d.y, -1};
  const Vec3<double> offset = Frame<double>::around(direction).world_from_local(local);
  sample.origin = Vec3<Real>(scene.center_m + offset * radius);
  if (!is_finite(sample.origin)) sample.reason = NoLight::kOutOfRange;
}

/// The density with which start_on_scene_disk starts a ray at `position`; 0 off the disk.
template <std::floating_point Real>
AreaPdf<Real> scene_disk_pdf(const Vec3<Real>& position, const Vec3<Real>& direction,
                             const SceneSphere& scene) {
  const double radius = scene.radius_m;
  const Vec3<double> w(direction);
  const Vec3<double> from_center = Vec3<double>(position) - scene.center_m;
  // Each coordinate of a position is rounded once.  A direction adds a rounding of the radius.
  const double slack =
      8 * kInputRounding * (radius + max_abs(Vec3<double>(position)) + max_abs(scene.center_m));
  const double along = dot(from_center, w);
  const Vec3<double> across = from_center - w * along;
  if (!(std::fabs(along + radius) <= slack && length(across) <= radius + slack)) return {};
  const auto pdf = static_cast<Real>(concentric_disk_pdf(radius).per_m2);
  return {std::isfinite(pdf) ? pdf : 0};
}

/// Whether two unit vectors are equal to within their roundings.
template <std::floating_point Real>
bool same_direction(const Vec3<Real>& a, const Vec3<Real>& b) {
  const auto same = [](Real a, Real b) {
    return std::fabs(a - b) <= static_cast<Real>(4 * kInputRounding);  // of single numbers
  };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

}  // namespace lucerna

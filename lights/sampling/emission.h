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
inline Power approximate_power(const Rgb& lumens, const Power& power) {
  return {lumens, std::fabs(luminance(lumens - power.lumens)) + power.error_lumens};
}

/// Sets the reason of a sample that was chosen with `density` (of position or of direction).  Value
/// and density belong to the rounded sample.  kOutsideCone if rounding leads out of the light or to
/// a value of 0.  kOutOfRange where the density is not a positive `double`.
inline void settle(double density, EmissionSample& sample) {
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
inline void start_on_scene_disk(Vec2 u, const Vec3& direction, const SceneSphere& scene,
                                EmissionSample& sample) {
  const double radius = scene.radius_m;
  sample.direction = direction;
  sample.pdf_position = {concentric_disk_pdf(radius).per_m2};
  if (!(sample.pdf_position.per_m2 > 0 && std::isfinite(sample.pdf_position.per_m2))) {
    sample.pdf_position = {};
    sample.reason = NoLight::kDegenerate;
    return;
  }
  const Vec2 d = sample_concentric_disk(Vec2{u.x, u.y});
  const Vec3 local{d.x, d.y, -1};
  const Vec3 offset = Frame::around(direction).world_from_local(local);
  sample.origin = scene.center_m + offset * radius;
  if (!is_finite(sample.origin)) sample.reason = NoLight::kOutOfRange;
}

/// The density with which start_on_scene_disk starts a ray at `position`; 0 off the disk.
inline AreaPdf scene_disk_pdf(const Vec3& position, const Vec3& direction,
                              const SceneSphere& scene) {
  const double radius = scene.radius_m;
  const Vec3 w(direction);
  const Vec3 from_center = position - scene.center_m;
  // Each coordinate of a position is rounded once.  A direction adds a rounding of the radius.
  const double slack = 8 * kInputRounding * (radius + max_abs(position) + max_abs(scene.center_m));
  const double along = dot(from_center, w);
  const Vec3 across = from_center - w * along;
  if (!(std::fabs(along + radius) <= slack && length(across) <= radius + slack)) return {};
  const auto pdf = concentric_disk_pdf(radius).per_m2;
  return {std::isfinite(pdf) ? pdf : 0};
}

/// Whether two unit vectors are equal to within their roundings.
inline bool same_direction(const Vec3& a, const Vec3& b) {
  const auto same = [](double a, double b) {
    return std::fabs(a - b) <= 4 * kInputRounding;  // of single numbers
  };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

}  // namespace lucerna

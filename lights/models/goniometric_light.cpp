#include "lights/models/goniometric_light.h"

#include <cmath>
#include <numbers>

#include "lights/maths/axes.h"
#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"
#include "lights/sampling/sampling.h"

namespace lucerna {
namespace {

absl::Status check_axes(const Frame& axes) {
  for (const Vec3& axis : {axes.s, axes.t, axes.n})
    if (auto s = check_direction("goniometric.axes", axis); !s.ok()) return s;
  const double longest = std::fmax(length(axes.s), std::fmax(length(axes.t), length(axes.n)));
  const Vec3 s = axes.s / longest, t = axes.t / longest, n = axes.n / longest;
  // Axes written with six digits have errors of this size.  Products of rotations in double have
  // far smaller ones.
  constexpr double kTolerance = 1e-5;
  const bool good = std::fabs(dot(s, t)) <= kTolerance && std::fabs(dot(t, n)) <= kTolerance &&
                    std::fabs(dot(n, s)) <= kTolerance && length(s) >= 1 - kTolerance &&
                    length(t) >= 1 - kTolerance && length(n) >= 1 - kTolerance;
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format(
      "goniometric.axes = ({}, {}, {}), ({}, {}, {}), ({}, {}, {}), allowed: at right angles and "
      "of equal length (rotations, mirrors, equal scale on all axes)",
      axes.s.x, axes.s.y, axes.s.z, axes.t.x, axes.t.y, axes.t.z, axes.n.x, axes.n.y, axes.n.z));
}

}  // namespace

GoniometricLightParams in_space(GoniometricLightParams params, const Deformation& map) {
  params.axes = map.own_from_world(params.axes);
  params.own_space = nullptr;
  return params;
}

double flux_of_unit_intensity_lm(const GoniometricLightParams& params) {
  if (params.web) return params.web->flux_lm();
  if (params.map) return params.map->flux_lm();
  return 4 * std::numbers::pi;
}

absl::Status GoniometricIntensity::check(const Params& params, const Vec3& origin_m) {
  if (auto s = check_position("goniometric.position", params.position_m, origin_m); !s.ok())
    return s;
  if (auto s = check_axes(params.axes); !s.ok()) return s;
  if (params.web && params.map)
    return absl::InvalidArgumentError("goniometric.web and goniometric.map, allowed: one of them");
  const std::string_view unit = params.web ? "" : "cd";
  if (auto s = check_light_value("goniometric.intensity", params.intensity, unit); !s.ok())
    return s;
  if (params.web || params.map) {
    const double max_cd = params.web ? params.web->max_cd() : params.map->max_cd();
    const Rgb largest = params.intensity * max_cd;
    if (auto s =
            check_light_value("goniometric.intensity times the largest of the file", largest, "cd");
        !s.ok())
      return s;
  }
  return absl::OkStatus();
}

GoniometricIntensity::GoniometricIntensity(const Params& params)
    : params_(params), axes_(orthonormal(params.axes)) {}

double GoniometricIntensity::share(const Vec3& w) const {
  return distribution(1.0, [&](const auto& d) { return d.at(axes_.local_from_world(w)); });
}

bool GoniometricIntensity::is_black() const {
  return params_.intensity.is_black() || !(flux_of_unit_intensity_lm(params_) > 0);
}

Rgb GoniometricIntensity::intensity(const Vec3& w) const {
  if (!is_finite(w) || w == Vec3{}) return {};
  return Rgb(params_.intensity * share(w));
}

std::optional<Rgb> GoniometricIntensity::towards(const Vec3& w, const Vec3&) const {
  const double towards = share(w);
  if (!(towards > 0)) return std::nullopt;
  return params_.intensity * towards;
}

SolidAnglePdf GoniometricIntensity::direction_pdf(const Vec3& w) const {
  return distribution(uniform_sphere_pdf(),
                      [&](const auto& d) { return d.pdf(axes_.local_from_world(w)); });
}

void GoniometricIntensity::sample(Vec2 u_direction, EmissionSample& sample) const {
  const Vec2 u{u_direction.x, u_direction.y};
  const Vec3 w = axes_.world_from_local(
      distribution(sample_uniform_sphere(u), [&](const auto& d) { return d.sample(u); }));
  sample.direction = w;
  // Both belong to the rounded direction.
  sample.pdf_direction = {direction_pdf(w).per_sr};
  sample.value = Rgb(params_.intensity * share(w));
  settle(sample.pdf_direction.per_sr, sample);
}

double GoniometricIntensity::per_sr(const Vec3& w) const {
  if (w == Vec3{} || is_black()) return 0;
  return direction_pdf(w).per_sr;
}

Power GoniometricIntensity::power() const {
  return {params_.intensity * flux_of_unit_intensity_lm(params_), 0};
}

Power GoniometricIntensity::power_approximate() const {
  if (!params_.map) return power();
  return approximate_power(params_.intensity * (params_.map->mean_cd() * (4 * std::numbers::pi)),
                           power());
}

EmissionCone GoniometricIntensity::cone() const {
  const EmissionCone everywhere{.half_angle_rad = std::numbers::pi};
  const EmissionCone cone = distribution(everywhere, [](const auto& d) { return d.cone(); });
  return {axes_.world_from_local(cone.axis), cone.half_angle_rad};
}

template class IntensityLight<GoniometricIntensity>;

}  // namespace lucerna

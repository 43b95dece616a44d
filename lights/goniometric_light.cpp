#include "lights/goniometric_light.h"

#include <cmath>
#include <numbers>

#include "lights/inverse_square.h"
#include "lights/sampling.h"
#include "lights/validation.h"

namespace lucerna {
namespace {

absl::Status check_axes(const Frame<double>& axes) {
  for (const Vec3<double>& axis : {axes.s, axes.t, axes.n})
    if (auto s = check_direction("goniometric.axes", axis); !s.ok()) return s;
  const double longest = std::fmax(length(axes.s), std::fmax(length(axes.t), length(axes.n)));
  const Vec3<double> s = axes.s / longest, t = axes.t / longest, n = axes.n / longest;
  // What is left of products of rotations in double is far below; written in a file with six
  // digits, they are this close.
  constexpr double kTolerance = 1e-5;
  const bool good = std::fabs(dot(s, t)) <= kTolerance && std::fabs(dot(t, n)) <= kTolerance &&
                    std::fabs(dot(n, s)) <= kTolerance && length(s) >= 1 - kTolerance &&
                    length(t) >= 1 - kTolerance && length(n) >= 1 - kTolerance;
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format(
      "goniometric.axes = ({}, {}, {}), ({}, {}, {}), ({}, {}, {}), allowed: at right angles and "
      "of "
      "equal length (rotations, mirrors, equal scale on all axes)",
      axes.s.x, axes.s.y, axes.s.z, axes.t.x, axes.t.y, axes.t.z, axes.n.x, axes.n.y, axes.n.z));
}

/// Exactly at right angles, the last axis as it is and handedness kept.
Frame<double> orthonormal(const Frame<double>& axes) {
  const Vec3<double> n = normalized(axes.n);
  const Vec3<double> s0 = normalized(axes.s);
  const Vec3<double> s = normalized(s0 - n * dot(s0, n));
  const Vec3<double> t = cross(n, s);
  return {s, dot(t, axes.t) < 0 ? -t : t, n};
}

}  // namespace

template <std::floating_point Real>
absl::StatusOr<GoniometricLight<Real>> GoniometricLight<Real>::create(
    const Params& params, const Vec3<double>& origin_m) {
  if (auto s = check_position<Real>("goniometric.position", params.position_m, origin_m); !s.ok())
    return s;
  if (auto s = check_axes(params.axes); !s.ok()) return s;
  const std::string_view unit = params.web ? "" : "cd";
  if (auto s = check_light_value<Real>("goniometric.intensity", params.intensity, unit); !s.ok())
    return s;
  if (params.web) {
    const Rgb<double> largest = params.intensity * params.web->max_cd();
    if (auto s = check_light_value<Real>("goniometric.intensity times the largest of the file",
                                         largest, "cd");
        !s.ok())
      return s;
  }
  return GoniometricLight(params, origin_m);
}

template <std::floating_point Real>
GoniometricLight<Real>::GoniometricLight(const Params& params, const Vec3<double>& origin_m)
    : params_(params), position_(params.position_m - origin_m), axes_(orthonormal(params.axes)) {}

template <std::floating_point Real>
double GoniometricLight<Real>::distribution(const Vec3<double>& w) const {
  return params_.web ? params_.web->at(axes_.local_from_world(w)) : 1;
}

template <std::floating_point Real>
bool GoniometricLight<Real>::is_black() const {
  return params_.intensity.is_black() || (params_.web && !(params_.web->flux_lm() > 0));
}

template <std::floating_point Real>
Rgb<Real> GoniometricLight<Real>::intensity(const Vec3<Real>& w) const {
  if (!is_finite(w) || w == Vec3<Real>{}) return {};
  return Rgb<Real>(params_.intensity * distribution(Vec3<double>(w)));
}

template <std::floating_point Real>
LightSample<Real> GoniometricLight<Real>::sample_li(const Receiver<Real>& receiver,
                                                    Vec2<Real>) const {
  LightSample<Real> sample;
  const Way way = find_way(position_, receiver.position, sample);
  if (sample.reason != NoLight::kNone) return sample;
  if (is_black()) {
    sample.reason = NoLight::kBlack;
    return sample;
  }
  const double share = distribution(-way.wi);
  if (share > 0)
    set_inverse_square(params_.intensity * share, way.distance_m, sample);
  else
    sample.reason = NoLight::kOutsideCone;
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> GoniometricLight<Real>::pdf_li(const Receiver<Real>&, const Vec3<Real>&) const {
  return {};
}

template <std::floating_point Real>
SolidAnglePdf<double> GoniometricLight<Real>::direction_pdf(const Vec3<double>& w) const {
  return params_.web ? params_.web->pdf(axes_.local_from_world(w)) : uniform_sphere_pdf<double>();
}

template <std::floating_point Real>
EmissionSample<Real> GoniometricLight<Real>::sample_le(Vec2<Real>, Vec2<Real> u_direction,
                                                       const SceneSphere&) const {
  EmissionSample<Real> sample;
  sample.origin = position_;
  if (is_black()) {
    sample.reason = NoLight::kBlack;
    return sample;
  }
  const Vec2<double> u{u_direction.x, u_direction.y};
  const Vec3<double> w =
      axes_.world_from_local(params_.web ? params_.web->sample(u) : sample_uniform_sphere(u));
  sample.direction = Vec3<Real>(w);
  // Value and density of the direction as it is rounded, which pdf_le will be asked for.
  const Vec3<double> rounded(sample.direction);
  sample.pdf_direction = {static_cast<Real>(direction_pdf(rounded).per_sr)};
  sample.value = Rgb<Real>(params_.intensity * distribution(rounded));
  // Rounded out of the lit angles, or where the intensity comes down to 0.
  if (sample.value.is_black()) {
    sample.reason = NoLight::kOutsideCone;
  } else if (!(sample.pdf_direction.per_sr > 0 && std::isfinite(sample.pdf_direction.per_sr))) {
    sample.reason = NoLight::kOutOfRange;
    sample.value = {};
  }
  return sample;
}

template <std::floating_point Real>
EmissionPdf<Real> GoniometricLight<Real>::pdf_le(const Vec3<Real>& position,
                                                 const Vec3<Real>& direction,
                                                 const SceneSphere&) const {
  if (position != position_ || !is_finite(direction) || direction == Vec3<Real>{} || is_black())
    return {};
  return {{}, {static_cast<Real>(direction_pdf(Vec3<double>(direction)).per_sr)}};
}

template <std::floating_point Real>
Power GoniometricLight<Real>::power(const SceneSphere&) const {
  return {params_.intensity * (params_.web ? params_.web->flux_lm() : 4 * std::numbers::pi), 0};
}

template <std::floating_point Real>
Power GoniometricLight<Real>::power_approximate(const SceneSphere& scene) const {
  return power(scene);
}

template <std::floating_point Real>
std::optional<LightBounds<Real>> GoniometricLight<Real>::bounds() const {
  LightBounds<Real> bounds{.lower = position_, .upper = position_, .cone_rad = std::numbers::pi};
  if (params_.web) {
    const PhotometricWeb::Cone& cone = params_.web->cone();
    bounds.axis = Vec3<Real>(cone.along_minus_z ? -axes_.n : axes_.n);
    bounds.cone_rad = cone.half_angle_rad;
  }
  return bounds;
}

template class GoniometricLight<float>;
template class GoniometricLight<double>;

}  // namespace lucerna

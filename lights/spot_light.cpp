#include "lights/spot_light.h"

#include <algorithm>
#include <numbers>

#include "lights/inverse_square.h"
#include "lights/validation.h"

namespace lucerna {
namespace {

/// Without the cancellation of 1 - cos, which is 0 in float below 0.02 degrees.
double one_minus_cos(double angle_rad) {
  const double s = std::sin(angle_rad / 2);
  return 2 * s * s;
}

absl::Status check_angles(const SpotLightParams& params) {
  const double cone = params.cone_half_angle_rad;
  if (!(cone > 0 && cone <= std::numbers::pi)) {
    return absl::InvalidArgumentError(
        fmt::format("spot.cone_half_angle = {} rad, allowed (0, pi]", cone));
  }
  const double start = params.falloff_start_rad;
  if (!(start >= 0 && start <= cone)) {
    return absl::InvalidArgumentError(fmt::format(
        "spot.falloff_start = {} rad, allowed [0, {}], the cone's half angle", start, cone));
  }
  return absl::OkStatus();
}

}  // namespace

template <std::floating_point Real>
absl::StatusOr<SpotLight<Real>> SpotLight<Real>::create(const Params& params,
                                                        const Vec3<double>& origin_m) {
  if (auto s = check_position<Real>("spot.position", params.position_m, origin_m); !s.ok()) {
    return s;
  }
  if (auto s = check_direction("spot.axis", params.axis); !s.ok()) return s;
  if (auto s = check_light_value<Real>("spot.intensity", params.intensity_cd, "cd"); !s.ok()) {
    return s;
  }
  if (auto s = check_angles(params); !s.ok()) return s;
  return SpotLight(params, origin_m);
}

template <std::floating_point Real>
SpotLight<Real>::SpotLight(const Params& params, const Vec3<double>& origin_m)
    : params_(params),
      position_(params.position_m - origin_m),
      axis_(normalized(params.axis)),
      one_minus_cos_cone_(one_minus_cos(params.cone_half_angle_rad)),
      // cos s - cos c = 2 sin((c + s) / 2) sin((c - s) / 2): does not cancel for a narrow edge.
      edge_(2 * std::sin((params.cone_half_angle_rad + params.falloff_start_rad) / 2) *
            std::sin((params.cone_half_angle_rad - params.falloff_start_rad) / 2)) {}

template <std::floating_point Real>
double SpotLight<Real>::falloff(const Vec3<double>& w) const {
  // 1 - cos of the angle between unit vectors is half their chord's square: exact near the axis.
  const Vec3<double> chord = w - axis_;
  const double inside = one_minus_cos_cone_ - std::min(2.0, dot(chord, chord) / 2);
  if (edge_ <= 0) return inside >= 0 ? 1 : 0;
  const double t = std::clamp(inside / edge_, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

template <std::floating_point Real>
Rgb<Real> SpotLight<Real>::intensity(const Vec3<Real>& w) const {
  // To unit length in double: a float's error of length is as large as the narrowest cones.
  const Vec3<double> unit = normalized(Vec3<double>(w));
  if (!is_finite(unit)) return {};
  return Rgb<Real>(params_.intensity_cd * falloff(unit));
}

template <std::floating_point Real>
LightSample<Real> SpotLight<Real>::sample_li(const Receiver<Real>& receiver, Vec2<Real>) const {
  LightSample<Real> sample;
  const Way way = find_way(position_, receiver.position, sample);
  if (sample.reason != NoLight::kNone) return sample;
  const double share = falloff(-way.wi);
  if (share > 0 || params_.intensity_cd.is_black()) {
    set_inverse_square(params_.intensity_cd * share, way.distance_m, sample);
  } else {
    sample.reason = NoLight::kOutsideCone;
  }
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> SpotLight<Real>::pdf_li(const Receiver<Real>&, const Vec3<Real>&) const {
  return {};
}

template <std::floating_point Real>
Power SpotLight<Real>::power(const SceneSphere&) const {
  const double full = one_minus_cos(params_.falloff_start_rad);
  return {params_.intensity_cd * (2 * std::numbers::pi * (full + edge_ / 2)), 0};
}

template class SpotLight<float>;
template class SpotLight<double>;

}  // namespace lucerna

#include "lights/models/projection_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lights/maths/axes.h"
#include "lights/maths/validation.h"
#include "lights/models/emission.h"
#include "lights/models/inverse_square.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

template <std::floating_point Real>
absl::StatusOr<ProjectionLight<Real>> ProjectionLight<Real>::create(const Params& params,
                                                                    const Vec3<double>& origin_m) {
  if (params.picture == nullptr) return absl::InvalidArgumentError("projection.picture is missing");
  if (auto s = check_position<Real>("projection.position", params.position_m, origin_m); !s.ok())
    return s;
  if (auto s = check_right_angles("projection.axes", params.axes); !s.ok()) return s;
  if (auto s = check_light_value<Real>("projection.intensity", params.intensity_cd, "cd"); !s.ok())
    return s;
  if (auto s = check_light_value<Real>("projection.intensity of the brightest texel",
                                       params.intensity_cd * params.picture->brightest(), "cd");
      !s.ok())
    return s;
  return ProjectionLight(params, origin_m);
}

template <std::floating_point Real>
ProjectionLight<Real>::ProjectionLight(const Params& params, const Vec3<double>& origin_m)
    : params_(params), position_(params.position_m - origin_m), axes_(orthonormal(params.axes)) {}

template <std::floating_point Real>
Rgb<double> ProjectionLight<Real>::value_at(const Vec3<double>& w) const {
  const std::optional<Vec2<double>> p = params_.picture->find(axes_.local_from_world(w));
  return p ? params_.picture->lookup(*p) : Rgb<double>{};
}

template <std::floating_point Real>
Rgb<Real> ProjectionLight<Real>::intensity(const Vec3<Real>& w) const {
  return Rgb<Real>(params_.intensity_cd * value_at(Vec3<double>(w)));
}

template <std::floating_point Real>
LightSample<Real> ProjectionLight<Real>::sample_li(const Receiver<Real>& receiver,
                                                   Vec2<Real>) const {
  LightSample<Real> sample;
  const Way way = find_way(position_, receiver.position, sample);
  if (sample.reason != NoLight::kNone) return sample;
  if (is_black()) {
    sample.reason = NoLight::kBlack;
    return sample;
  }
  const Rgb<double> intensity_cd = params_.intensity_cd * value_at(-way.wi);
  if (intensity_cd.is_black())
    sample.reason = NoLight::kOutsideCone;
  else
    set_inverse_square(intensity_cd, way, sample);
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> ProjectionLight<Real>::pdf_li(const Receiver<Real>&, const Vec3<Real>&) const {
  return {};
}

// Not inlined: GCC 12 at -O2 keeps a direction in double where it has just been rounded to float.
template <std::floating_point Real>
[[gnu::noinline]] typename ProjectionLight<Real>::Rounded ProjectionLight<Real>::at_rounded(
    const Vec3<Real>& w) const {
  const Vec3<double> local = axes_.local_from_world(Vec3<double>(w));
  return {value_at(Vec3<double>(w)), params_.picture->per_sr(local)};
}

template <std::floating_point Real>
EmissionSample<Real> ProjectionLight<Real>::sample_le(Vec2<Real>, Vec2<Real> u_direction,
                                                      const SceneSphere&) const {
  EmissionSample<Real> sample;
  sample.origin = position_;
  if (is_black()) {
    sample.reason = NoLight::kBlack;
    return sample;
  }
  const Vec3<double> w = params_.picture->sample({double{u_direction.x}, double{u_direction.y}});
  sample.direction = Vec3<Real>(axes_.world_from_local(w));
  // What pdf_le will say of the direction as it is rounded.
  const Rounded rounded = at_rounded(sample.direction);
  sample.value = Rgb<Real>(params_.intensity_cd * rounded.value);
  sample.pdf_direction = {static_cast<Real>(rounded.per_sr)};
  settle(sample.pdf_direction.per_sr, sample);
  return sample;
}

template <std::floating_point Real>
EmissionPdf<Real> ProjectionLight<Real>::pdf_le(const Vec3<Real>& position,
                                                const Vec3<Real>& direction,
                                                const SceneSphere&) const {
  if (!same_float(position, position_) || !is_finite(direction) || is_black()) return {};
  return {{}, {static_cast<Real>(at_rounded(direction).per_sr)}};
}

template <std::floating_point Real>
Power ProjectionLight<Real>::power(const SceneSphere&) const {
  const Rgb<double> lumens = params_.intensity_cd * params_.picture->integral_sr();
  return {lumens, luminance(lumens) * params_.picture->relative_error()};
}

template <std::floating_point Real>
Power ProjectionLight<Real>::power_approximate(const SceneSphere& scene) const {
  const ProjectedPicture& picture = *params_.picture;
  if (picture.params().image)
    return approximate_power(params_.intensity_cd * picture.integral_by_centres_sr(), power(scene));
  // 1 - cos of the angle at a corner as sin^2 / (1 + cos).
  const double tan = std::hypot(picture.half().x, picture.half().y);
  const double cos = 1 / std::sqrt(1 + tan * tan);
  const double cone_sr = 2 * std::numbers::pi * (tan * cos) * (tan * cos) / (1 + cos);
  return approximate_power(params_.intensity_cd * cone_sr, power(scene));
}

template <std::floating_point Real>
std::optional<LightBounds<Real>> ProjectionLight<Real>::bounds() const {
  // By what roundings turn the axis and a direction.
  constexpr double kTurned = 4 * kInputRounding;
  const Vec2<double> half = params_.picture->half();
  return LightBounds<Real>{.lower = position_,
                           .upper = position_,
                           .axis = Vec3<Real>(axes_.n),
                           .cone_rad = std::atan(std::hypot(half.x, half.y)) + kTurned};
}

template class ProjectionLight<float>;
template class ProjectionLight<double>;

}  // namespace lucerna

#include "lights/models/projection_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lights/maths/axes.h"
#include "lights/maths/validation.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

ProjectionLightParams in_space(ProjectionLightParams params, const Deformation& map) {
  params.axes = map.own_from_world(params.axes);
  params.own_space = nullptr;
  return params;
}

template <typename Real>
absl::Status ProjectionIntensity<Real>::check(const Params& params, const Vec3<double>& origin_m) {
  if (params.picture == nullptr) return absl::InvalidArgumentError("projection.picture is missing");
  if (auto s = check_position<Real>("projection.position", params.position_m, origin_m); !s.ok())
    return s;
  if (auto s = check_right_angles("projection.axes", params.axes); !s.ok()) return s;
  if (auto s = check_light_value<Real>("projection.intensity", params.intensity_cd, "cd"); !s.ok())
    return s;
  return check_light_value<Real>("projection.intensity of the brightest texel",
                                 params.intensity_cd * params.picture->brightest(), "cd");
}

template <typename Real>
ProjectionIntensity<Real>::ProjectionIntensity(const Params& params)
    : params_(params), axes_(orthonormal(params.axes)) {}

template <typename Real>
Rgb<double> ProjectionIntensity<Real>::value_at(const Vec3<double>& w) const {
  const std::optional<Vec2<double>> p = params_.picture->find(axes_.local_from_world(w));
  return p ? params_.picture->lookup(*p) : Rgb<double>{};
}

template <typename Real>
Rgb<Real> ProjectionIntensity<Real>::intensity(const Vec3<Real>& w) const {
  return Rgb<Real>(params_.intensity_cd * value_at(Vec3<double>(w)));
}

template <typename Real>
std::optional<Rgb<double>> ProjectionIntensity<Real>::towards(const Vec3<double>& w,
                                                              const Vec3<double>&) const {
  const Rgb<double> intensity_cd = params_.intensity_cd * value_at(w);
  if (intensity_cd.is_black()) return std::nullopt;
  return intensity_cd;
}

// Not inlined: GCC 12 at -O2 keeps a direction in double where it has just been rounded to float.
template <typename Real>
[[gnu::noinline]] typename ProjectionIntensity<Real>::Rounded ProjectionIntensity<Real>::at_rounded(
    const Vec3<Real>& w) const {
  const Vec3<double> local = axes_.local_from_world(Vec3<double>(w));
  return {value_at(Vec3<double>(w)), params_.picture->per_sr(local)};
}

template <typename Real>
void ProjectionIntensity<Real>::sample(Vec2<Real> u_direction, EmissionSample<Real>& sample) const {
  const Vec3<double> w = params_.picture->sample({double{u_direction.x}, double{u_direction.y}});
  sample.direction = Vec3<Real>(axes_.world_from_local(w));
  // Value and density belong to the rounded direction, as in per_sr.
  const Rounded rounded = at_rounded(sample.direction);
  sample.value = Rgb<Real>(params_.intensity_cd * rounded.value);
  sample.pdf_direction = {static_cast<Real>(rounded.per_sr)};
  settle(sample.pdf_direction.per_sr, sample);
}

template <typename Real>
Real ProjectionIntensity<Real>::per_sr(const Vec3<Real>& w) const {
  return is_black() ? 0 : static_cast<Real>(at_rounded(w).per_sr);
}

template <typename Real>
Power ProjectionIntensity<Real>::power() const {
  const Rgb<double> lumens = params_.intensity_cd * params_.picture->integral_sr();
  return {lumens, luminance(lumens) * params_.picture->relative_error()};
}

template <typename Real>
Power ProjectionIntensity<Real>::power_approximate() const {
  const ProjectedPicture& picture = *params_.picture;
  if (picture.params().image)
    return approximate_power(params_.intensity_cd * picture.integral_by_centres_sr(), power());
  // 1 - cos of the angle at a corner, computed as sin^2 / (1 + cos).
  const double tan = std::hypot(picture.half().x, picture.half().y);
  const double cos = 1 / std::sqrt(1 + tan * tan);
  const double cone_sr = 2 * std::numbers::pi * (tan * cos) * (tan * cos) / (1 + cos);
  return approximate_power(params_.intensity_cd * cone_sr, power());
}

template <typename Real>
EmissionCone ProjectionIntensity<Real>::cone() const {
  // Wider by the rounding of the axis and of a direction.
  constexpr double kTurned = 4 * kInputRounding;
  const Vec2<double> half = params_.picture->half();
  return {axes_.n, std::atan(std::hypot(half.x, half.y)) + kTurned};
}

template class ProjectionIntensity<float>;
template class ProjectionIntensity<double>;

}  // namespace lucerna

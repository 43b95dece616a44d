#include "lights/models/point_light.h"

#include <numbers>

#include "lights/maths/validation.h"
#include "lights/sampling/sampling.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

template <typename Real>
absl::Status IsotropicProfile<Real>::check(const Params& params, const Vec3<double>& origin_m) {
  if (auto s = check_position<Real>("point.position", params.position_m, origin_m); !s.ok())
    return s;
  return check_light_value<Real>("point.intensity", params.intensity_cd, "cd");
}

template <typename Real>
Power IsotropicProfile<Real>::power() const {
  return {params_.intensity_cd * (4 * std::numbers::pi), 0};
}

template <typename Real>
void IsotropicProfile<Real>::sample(Vec2<Real> u, EmissionSample<Real>& ray) const {
  ray.direction = sample_uniform_sphere(u);
  ray.pdf_direction = uniform_sphere_pdf<Real>();
  ray.value = Rgb<Real>(params_.intensity_cd);
  if (ray.value.is_black()) ray.reason = NoLight::kBlack;
}

template <typename Real>
Real IsotropicProfile<Real>::per_sr(const Vec3<Real>&) const {
  return uniform_sphere_pdf<Real>().per_sr;
}

template class IsotropicProfile<float>;
template class IsotropicProfile<double>;
template class IntensityLight<float, IsotropicProfile>;
template class IntensityLight<double, IsotropicProfile>;

}  // namespace lucerna

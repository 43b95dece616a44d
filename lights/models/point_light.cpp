#include "lights/models/point_light.h"

#include <numbers>

#include "lights/maths/validation.h"
#include "lights/models/emission.h"
#include "lights/models/inverse_square.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

template <std::floating_point Real>
absl::StatusOr<PointLight<Real>> PointLight<Real>::create(const Params& params,
                                                          const Vec3<double>& origin_m) {
  if (auto s = check_position<Real>("point.position", params.position_m, origin_m); !s.ok()) {
    return s;
  }
  if (auto s = check_light_value<Real>("point.intensity", params.intensity_cd, "cd"); !s.ok()) {
    return s;
  }
  return PointLight(params, origin_m);
}

template <std::floating_point Real>
PointLight<Real>::PointLight(const Params& params, const Vec3<double>& origin_m)
    : params_(params), position_(params.position_m - origin_m) {}

template <std::floating_point Real>
SolidAnglePdf<Real> PointLight<Real>::pdf_li(const Receiver<Real>&, const Vec3<Real>&) const {
  return {};
}

template <std::floating_point Real>
Power PointLight<Real>::power(const SceneSphere&) const {
  return {params_.intensity_cd * (4 * std::numbers::pi), 0};
}

template <std::floating_point Real>
Power PointLight<Real>::power_approximate(const SceneSphere& scene) const {
  return power(scene);
}

template <std::floating_point Real>
EmissionSample<Real> PointLight<Real>::sample_le(Vec2<Real>, Vec2<Real> u_direction,
                                                 const SceneSphere&) const {
  EmissionSample<Real> sample;
  sample.origin = position_;
  sample.direction = sample_uniform_sphere(u_direction);
  sample.pdf_direction = uniform_sphere_pdf<Real>();
  sample.value = Rgb<Real>(params_.intensity_cd);
  if (sample.value.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

template <std::floating_point Real>
EmissionPdf<Real> PointLight<Real>::pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                                           const SceneSphere&) const {
  if (!same_float(position, position_) || !is_finite(direction)) return {};
  return {{}, uniform_sphere_pdf<Real>()};
}

template <std::floating_point Real>
std::optional<LightBounds<Real>> PointLight<Real>::bounds() const {
  return LightBounds<Real>{.lower = position_, .upper = position_, .cone_rad = std::numbers::pi};
}

template class PointLight<float>;
template class PointLight<double>;

}  // namespace lucerna

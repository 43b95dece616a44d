#include "lights/models/distant_light.h"

#include <limits>
#include <numbers>

#include "lights/maths/validation.h"
#include "lights/sampling/emission.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

template <std::floating_point Real>
absl::StatusOr<DistantLight<Real>> DistantLight<Real>::create(const Params& params,
                                                              const Vec3<double>&) {
  if (auto s = check_direction("distant.to_light", params.to_light); !s.ok()) return s;
  if (auto s = check_light_value<Real>("distant.illuminance", params.illuminance_lx, "lx");
      !s.ok()) {
    return s;
  }
  return DistantLight(params);
}

template <std::floating_point Real>
DistantLight<Real>::DistantLight(const Params& params)
    : params_(params),
      to_light_(normalized(params.to_light)),
      illuminance_(params.illuminance_lx) {}

template <std::floating_point Real>
LightSample<Real> DistantLight<Real>::sample_li(const Receiver<Real>& receiver, Vec2<Real>) const {
  LightSample<Real> sample;
  sample.delta = true;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  sample.wi = to_light_;
  sample.distance = std::numeric_limits<Real>::infinity();
  sample.value = illuminance_;
  if (illuminance_.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> DistantLight<Real>::pdf_li(const Receiver<Real>&, const Vec3<Real>&) const {
  return {};
}

template <std::floating_point Real>
Power DistantLight<Real>::power(const SceneSphere& scene) const {
  if (params_.illuminance_lx.is_black()) return {};
  return {params_.illuminance_lx * scene.radius_m * scene.radius_m * std::numbers::pi, 0};
}

template <std::floating_point Real>
Power DistantLight<Real>::power_approximate(const SceneSphere& scene) const {
  return power(scene);
}

template <std::floating_point Real>
EmissionSample<Real> DistantLight<Real>::sample_le(Vec2<Real> u_position, Vec2<Real>,
                                                   const SceneSphere& scene) const {
  EmissionSample<Real> sample;
  start_on_scene_disk(u_position, -normalized(params_.to_light), scene, sample);
  sample.direction = -to_light_;
  if (illuminance_.is_black()) sample.reason = NoLight::kBlack;
  if (sample.reason == NoLight::kNone) sample.value = illuminance_;
  return sample;
}

template <std::floating_point Real>
EmissionPdf<Real> DistantLight<Real>::pdf_le(const Vec3<Real>& position,
                                             const Vec3<Real>& direction,
                                             const SceneSphere& scene) const {
  if (!same_direction(direction, -to_light_) || illuminance_.is_black()) return {};
  return {scene_disk_pdf(position, direction, scene), {}};
}

template class DistantLight<float>;
template class DistantLight<double>;

}  // namespace lucerna

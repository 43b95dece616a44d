#include "lights/models/infinite_light.h"

#include <limits>
#include <numbers>

#include "lights/models/irradiance.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/sampling.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

template <std::floating_point Real>
absl::StatusOr<UniformInfiniteLight<Real>> UniformInfiniteLight<Real>::create(const Params& params,
                                                                              const Vec3<double>&) {
  if (auto s = check_light_value<Real>("infinite.radiance", params.radiance_cd_m2, "cd/m2");
      !s.ok()) {
    return s;
  }
  return UniformInfiniteLight(params);
}

template <std::floating_point Real>
UniformInfiniteLight<Real>::UniformInfiniteLight(const Params& params)
    : params_(params), radiance_(params.radiance_cd_m2) {}

template <std::floating_point Real>
LightSample<Real> UniformInfiniteLight<Real>::sample_li(const Receiver<Real>& receiver,
                                                        Vec2<Real> u) const {
  LightSample<Real> sample;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  sample.wi = sample_uniform_sphere(u);
  sample.distance = std::numeric_limits<Real>::infinity();
  sample.pdf = uniform_sphere_pdf<Real>();
  sample.value = radiance_;
  if (radiance_.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> UniformInfiniteLight<Real>::pdf_li(const Receiver<Real>& receiver,
                                                       const Vec3<Real>& wi) const {
  if (!is_finite(receiver.position) || !is_finite(wi) || radiance_.is_black()) return {};
  return uniform_sphere_pdf<Real>();
}

template <std::floating_point Real>
std::optional<Rgb<Real>> UniformInfiniteLight<Real>::irradiance(
    const Receiver<Real>& receiver) const {
  return irradiance_of(params_.radiance_cd_m2, receiver,
                       [](const Vec3<double>&) { return std::numbers::pi; });
}

template <std::floating_point Real>
Rgb<Real> UniformInfiniteLight<Real>::le_escaped(const Vec3<Real>&, const Vec3<Real>&) const {
  return radiance_;
}

template <std::floating_point Real>
Power UniformInfiniteLight<Real>::power(const SceneSphere& scene) const {
  if (params_.radiance_cd_m2.is_black()) return {};
  return {params_.radiance_cd_m2 * scene.radius_m * scene.radius_m * (4 * kPi * kPi), 0};
}

template <std::floating_point Real>
Power UniformInfiniteLight<Real>::power_approximate(const SceneSphere& scene) const {
  return power(scene);
}

template <std::floating_point Real>
EmissionSample<Real> UniformInfiniteLight<Real>::sample_le(Vec2<Real> u_position,
                                                           Vec2<Real> u_direction,
                                                           const SceneSphere& scene) const {
  EmissionSample<Real> sample;
  const Vec3<double> wi(sample_uniform_sphere(u_direction));
  start_on_scene_disk(u_position, -normalized(wi), scene, sample);
  sample.pdf_direction = uniform_sphere_pdf<Real>();
  if (radiance_.is_black()) sample.reason = NoLight::kBlack;
  if (sample.reason == NoLight::kNone) sample.value = radiance_;
  return sample;
}

template <std::floating_point Real>
EmissionPdf<Real> UniformInfiniteLight<Real>::pdf_le(const Vec3<Real>& position,
                                                     const Vec3<Real>& direction,
                                                     const SceneSphere& scene) const {
  if (radiance_.is_black()) return {};
  const AreaPdf<Real> at = scene_disk_pdf(position, direction, scene);
  if (!(at.per_m2 > 0)) return {};
  return {at, uniform_sphere_pdf<Real>()};
}

template class UniformInfiniteLight<float>;
template class UniformInfiniteLight<double>;

}  // namespace lucerna

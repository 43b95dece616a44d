#include "lights/models/infinite_light.h"

#include <limits>
#include <numbers>

#include "lights/maths/level_validation.h"
#include "lights/models/all_lights.h"
#include "lights/models/irradiance.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/sampling.h"

namespace lucerna {

absl::StatusOr<UniformInfiniteLight> UniformInfiniteLight::create(const Params& params,
                                                                  const Vec3&) {
  if (auto s = check_light_value("infinite.radiance", params.radiance_cd_m2, "cd/m2"); !s.ok()) {
    return s;
  }
  return UniformInfiniteLight(params);
}

UniformInfiniteLight::UniformInfiniteLight(const Params& params)
    : LightBeyond(/*leaves_freely=*/false, /*has_irradiance=*/true),
      params_(params),
      radiance_(params.radiance_cd_m2) {}

LightSample UniformInfiniteLight::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample sample;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  sample.wi = sample_uniform_sphere(u);
  sample.distance = std::numeric_limits<double>::infinity();
  sample.pdf = uniform_sphere_pdf();
  sample.value = radiance_;
  if (radiance_.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

SolidAnglePdf UniformInfiniteLight::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  if (!is_finite(receiver.position) || !is_finite(wi) || radiance_.is_black()) return {};
  return uniform_sphere_pdf();
}

std::optional<Rgb> UniformInfiniteLight::irradiance(const Receiver& receiver) const {
  return irradiance_of(params_.radiance_cd_m2, receiver,
                       [](const Vec3&) { return std::numbers::pi; });
}

Rgb UniformInfiniteLight::le_escaped(const Vec3&, const Vec3&) const { return radiance_; }

Power UniformInfiniteLight::power(const SceneSphere& scene) const {
  if (params_.radiance_cd_m2.is_black()) return {};
  return {params_.radiance_cd_m2 * scene.radius_m * scene.radius_m * (4 * kPi * kPi), 0};
}

Power UniformInfiniteLight::power_approximate(const SceneSphere& scene) const {
  return power(scene);
}

EmissionSample UniformInfiniteLight::sample_le(Vec2 u_position, Vec2 u_direction,
                                               const SceneSphere& scene) const {
  EmissionSample sample;
  const Vec3 wi(sample_uniform_sphere(u_direction));
  start_on_scene_disk(u_position, -normalized(wi), scene, sample);
  sample.pdf_direction = uniform_sphere_pdf();
  if (radiance_.is_black()) sample.reason = NoLight::kBlack;
  if (sample.reason == NoLight::kNone) sample.value = radiance_;
  return sample;
}

EmissionPdf UniformInfiniteLight::pdf_le(const Vec3& position, const Vec3& direction,
                                         const SceneSphere& scene, double) const {
  if (radiance_.is_black()) return {};
  const AreaPdf at = scene_disk_pdf(position, direction, scene);
  if (!(at.per_m2 > 0)) return {};
  return {at, uniform_sphere_pdf()};
}

std::optional<LightParams> UniformInfiniteLight::made_from() const { return params_; }

}  // namespace lucerna

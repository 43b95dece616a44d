#include "lights/models/distant_light.h"

#include <limits>
#include <numbers>

#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/emission.h"

namespace lucerna {

absl::StatusOr<DistantLight> DistantLight::create(const Params& params, const Vec3&) {
  if (auto s = check_direction("distant.to_light", params.to_light); !s.ok()) return s;
  if (auto s = check_light_value("distant.illuminance", params.illuminance_lx, "lx"); !s.ok()) {
    return s;
  }
  return DistantLight(params);
}

DistantLight::DistantLight(const Params& params)
    : DeltaLight(/*leaves_freely=*/false),
      params_(params),
      to_light_(normalized(params.to_light)),
      illuminance_(params.illuminance_lx) {}

LightSample DistantLight::sample_li(const Receiver& receiver, Vec2) const {
  LightSample sample;
  sample.delta = true;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  sample.wi = to_light_;
  sample.distance = std::numeric_limits<double>::infinity();
  sample.value = illuminance_;
  if (illuminance_.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

Power DistantLight::power(const SceneSphere& scene) const {
  if (params_.illuminance_lx.is_black()) return {};
  return {params_.illuminance_lx * scene.radius_m * scene.radius_m * std::numbers::pi, 0};
}

Power DistantLight::power_approximate(const SceneSphere& scene) const { return power(scene); }

EmissionSample DistantLight::sample_le(Vec2 u_position, Vec2, const SceneSphere& scene) const {
  EmissionSample sample;
  start_on_scene_disk(u_position, -normalized(params_.to_light), scene, sample);
  sample.direction = -to_light_;
  if (illuminance_.is_black()) sample.reason = NoLight::kBlack;
  if (sample.reason == NoLight::kNone) sample.value = illuminance_;
  return sample;
}

EmissionPdf DistantLight::pdf_le(const Vec3& position, const Vec3& direction,
                                 const SceneSphere& scene, double) const {
  if (!same_direction(direction, -to_light_) || illuminance_.is_black()) return {};
  return {scene_disk_pdf(position, direction, scene), {}};
}

std::optional<LightParams> DistantLight::made_from() const { return params_; }

}  // namespace lucerna

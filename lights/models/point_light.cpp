#include "lights/models/point_light.h"

#include <numbers>

#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/sampling.h"

namespace lucerna {

absl::Status IsotropicProfile::check(const Params& params, const Vec3& origin_m) {
  if (auto s = check_position("point.position", params.position_m, origin_m); !s.ok()) return s;
  return check_light_value("point.intensity", params.intensity_cd, "cd");
}

Power IsotropicProfile::power() const { return {params_.intensity_cd * (4 * std::numbers::pi), 0}; }

void IsotropicProfile::sample(Vec2 u, EmissionSample& ray) const {
  ray.direction = sample_uniform_sphere(u);
  ray.pdf_direction = uniform_sphere_pdf();
  ray.value = Rgb(params_.intensity_cd);
  if (ray.value.is_black()) ray.reason = NoLight::kBlack;
}

double IsotropicProfile::per_sr(const Vec3&) const { return uniform_sphere_pdf().per_sr; }

template class IntensityLight<IsotropicProfile>;

}  // namespace lucerna

#include "lights/models/projection_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lights/maths/axes.h"
#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/inverse_square.h"

namespace lucerna {

ProjectionLightParams in_space(ProjectionLightParams params, const Deformation& map) {
  params.axes = map.own_from_world(params.axes);
  params.own_space = nullptr;
  return params;
}

absl::Status ProjectionIntensity::check(const Params& params, const Vec3& origin_m) {
  if (params.picture == nullptr) return absl::InvalidArgumentError("projection.picture is missing");
  if (auto s = check_position("projection.position", params.position_m, origin_m); !s.ok())
    return s;
  if (auto s = check_right_angles("projection.axes", params.axes); !s.ok()) return s;
  if (auto s = check_light_value("projection.intensity", params.intensity_cd, "cd"); !s.ok())
    return s;
  return check_light_value("projection.intensity of the brightest texel",
                           params.intensity_cd * params.picture->brightest(), "cd");
}

ProjectionIntensity::ProjectionIntensity(const Params& params)
    : params_(params), axes_(orthonormal(params.axes)) {}

Rgb ProjectionIntensity::value_at(const Vec3& w) const {
  const std::optional<Vec2> p = params_.picture->find(axes_.local_from_world(w));
  return p ? params_.picture->lookup(*p) : Rgb{};
}

Rgb ProjectionIntensity::intensity(const Vec3& w) const {
  return Rgb(params_.intensity_cd * value_at(w));
}

std::optional<Rgb> ProjectionIntensity::towards(const Vec3& w, const Vec3&) const {
  const Rgb intensity_cd = params_.intensity_cd * value_at(w);
  if (intensity_cd.is_black()) return std::nullopt;
  return intensity_cd;
}

void ProjectionIntensity::sample(Vec2 u_direction, EmissionSample& sample) const {
  const Vec3 w = params_.picture->sample({double{u_direction.x}, double{u_direction.y}});
  sample.direction = axes_.world_from_local(w);
  // Both belong to the rounded direction.
  sample.value = params_.intensity_cd * value_at(sample.direction);
  sample.pdf_direction = {per_sr(sample.direction)};
  settle(sample.pdf_direction.per_sr, sample);
}

double ProjectionIntensity::per_sr(const Vec3& w) const {
  return is_black() ? 0 : params_.picture->per_sr(axes_.local_from_world(w));
}

Power ProjectionIntensity::power() const {
  const Rgb lumens = params_.intensity_cd * params_.picture->integral_sr();
  return {lumens, luminance(lumens) * params_.picture->relative_error()};
}

Power ProjectionIntensity::power_approximate() const {
  const ProjectedPicture& picture = *params_.picture;
  if (picture.params().image)
    return approximate_power(params_.intensity_cd * picture.integral_by_centres_sr(), power());
  // 1 - cos of the angle at a corner, computed as sin^2 / (1 + cos).
  const double tan = std::hypot(picture.half().x, picture.half().y);
  const double cos = 1 / std::sqrt(1 + tan * tan);
  const double cone_sr = 2 * std::numbers::pi * (tan * cos) * (tan * cos) / (1 + cos);
  return approximate_power(params_.intensity_cd * cone_sr, power());
}

EmissionCone ProjectionIntensity::cone() const {
  // Wider by the rounding of the axis and of a direction.
  constexpr double kTurned = 4 * kInputRounding;
  const Vec2 half = params_.picture->half();
  return {axes_.n, std::atan(std::hypot(half.x, half.y)) + kTurned};
}

template class IntensityLight<ProjectionIntensity>;

}  // namespace lucerna

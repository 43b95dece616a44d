#include "lights/models/beam_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lights/maths/axes.h"
#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/sampling/emission.h"
#include "lights/shapes/shape.h"

namespace lucerna {
namespace {

/// From the middle to the corner of the smallest box with the largest coordinates.
Vec3 half_box(const BeamLightParams& params) {
  const Frame axes = orthonormal(params.axes);
  const Vec3 x = axes.s * (params.width_m / 2), y = axes.t * (params.height_m / 2);
  return {std::fabs(x.x) + std::fabs(y.x), std::fabs(x.y) + std::fabs(y.y),
          std::fabs(x.z) + std::fabs(y.z)};
}

}  // namespace

Bounds bounding_box(const BeamLightParams& params) {
  const Vec3 half = half_box(params);
  return {params.position_m - half, params.position_m + half};
}

absl::StatusOr<BeamLight> BeamLight::create(const Params& params, const Vec3& origin_m) {
  if (auto s = check_position("beam.position", params.position_m, origin_m); !s.ok()) return s;
  if (auto s = check_right_angles("beam.axes", params.axes); !s.ok()) return s;
  // The square of a side and its reciprocal must fit `double`.
  const double most = std::sqrt(std::numeric_limits<double>::max()) / 2;
  const double least = 2 * std::sqrt(std::numeric_limits<double>::min());
  for (const double side : {params.width_m, params.height_m})
    if (!(side >= least && side <= most))
      return absl::InvalidArgumentError(
          fmt::format("beam.width and height = {} and {} m, allowed: from {:.3g} to {:.3g}",
                      params.width_m, params.height_m, least, most));
  const auto [lower, upper] = bounding_box(params);
  for (const Vec3& corner : {lower, upper})
    if (auto s = check_position("beam's corner", corner, origin_m); !s.ok()) return s;
  if (auto s = check_light_value("beam.illuminance", params.illuminance_lx, "lx"); !s.ok())
    return s;
  if (params.image) {
    if (auto s = check_light_value("beam.illuminance of the brightest texel",
                                   params.illuminance_lx * params.image->brightest(), "lx");
        !s.ok())
      return s;
  }
  return BeamLight(params, origin_m);
}

BeamLight::BeamLight(const Params& params, const Vec3& origin_m)
    : DeltaLight(/*leaves_freely=*/true),
      params_(params),
      middle_(params.position_m - origin_m),
      axes_(orthonormal(params.axes)),
      direction_(axes_.n),
      mean_(params.image ? params.image->mean() : Rgb(1)),
      mean_luminance_(luminance(mean_)) {
  if (params_.image)
    distribution_ = std::make_shared<const ImageDistribution>(*params_.image, params_.filter,
                                                              ImageBorder::kClamp);
}

std::optional<Vec2> BeamLight::in_square(double x, double y, double slack_m) const {
  const double half_x = params_.width_m / 2, half_y = params_.height_m / 2;
  if (!(std::fabs(x) <= half_x + slack_m && std::fabs(y) <= half_y + slack_m)) return std::nullopt;
  return Vec2{std::clamp((1 + x / half_x) / 2, 0.0, 1.0),
              std::clamp((1 - y / half_y) / 2, 0.0, 1.0)};
}

std::optional<Vec2> BeamLight::locate(const Vec3& position, double slack_m) const {
  if (!is_finite(position)) return std::nullopt;
  const Vec3 p(position);
  const Vec3 local = axes_.local_from_world(p - middle_);
  const double slack =
      slack_m + 4 * kInputRounding *
                    (max_abs(p) + max_abs(middle_) + std::max(params_.width_m, params_.height_m));
  if (!(std::fabs(local.z) <= slack)) return std::nullopt;
  return in_square(local.x, local.y, slack);
}

Rgb BeamLight::value_at(const Vec2& p) const {
  if (!params_.image) return params_.illuminance_lx;
  return params_.illuminance_lx * params_.image->lookup(p, params_.filter, ImageBorder::kClamp);
}

double BeamLight::per_m2(const Vec2& p) const {
  return (distribution_ ? distribution_->pdf(p) : 1) / params_.width_m / params_.height_m;
}

LightSample BeamLight::sample_li(const Receiver& receiver, Vec2) const {
  LightSample sample;
  sample.delta = true;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  const Vec3 p(receiver.position);
  const Vec3 local = axes_.local_from_world(p - middle_);
  sample.wi = -direction_;
  if (local.z > 0) sample.distance = local.z;
  sample.point = p - axes_.n * local.z;
  if (is_black()) {
    sample.reason = NoLight::kBlack;
  } else if (!(local.z > 0)) {
    sample.reason = NoLight::kBehind;
  } else if (const auto at = in_square(local.x, local.y, 0); !at || value_at(*at).is_black()) {
    sample.reason = NoLight::kOutsideCone;
  } else if (const Rgb value(value_at(*at));
             !(sample.distance > 0 && std::isfinite(sample.distance)) || !is_finite(sample.point)) {
    sample.reason = NoLight::kOutOfRange;
  } else {
    sample.value = value;
  }
  return sample;
}

EmissionSample BeamLight::sample_le(Vec2 u_position, Vec2, const SceneSphere&) const {
  EmissionSample sample;
  sample.direction = direction_;
  if (is_black()) {
    sample.origin = middle_;
    sample.reason = NoLight::kBlack;
    return sample;
  }
  Vec2 p{double{u_position.x}, double{u_position.y}};
  if (distribution_) p = distribution_->sample(p).position;
  sample.origin = middle_ + axes_.s * ((p.x - 0.5) * params_.width_m) +
                  axes_.t * ((0.5 - p.y) * params_.height_m);
  // The density of the rounded position, as in pdf_le.
  const std::optional<Vec2> rounded = locate(sample.origin);
  if (rounded) {
    sample.value = Rgb(value_at(*rounded));
    sample.pdf_position = {per_m2(*rounded)};
  }
  settle(sample.pdf_position.per_m2, sample);
  return sample;
}

Rgb BeamLight::le_leaving(const Vec3& position, const Vec3&, double slack_m) const {
  const std::optional<Vec2> p = locate(position, slack_m);
  return p ? Rgb(value_at(*p)) : Rgb{};
}

EmissionPdf BeamLight::pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere&,
                              double slack_m) const {
  if (is_black() || !same_direction(direction, direction_)) return {};
  const std::optional<Vec2> p = locate(position, slack_m);
  if (!p) return {};
  return {{per_m2(*p)}, {}};
}

Power BeamLight::power(const SceneSphere&) const {
  return {params_.illuminance_lx * mean_ * params_.width_m * params_.height_m, 0};
}

std::optional<LightBounds> BeamLight::bounds() const {
  const Vec3 half = half_box(params_);
  const auto [lower, upper] = rounded_outwards(middle_ - half, middle_ + half);
  // The cone has the size of the axis's rounding.
  return LightBounds{
      .lower = lower, .upper = upper, .axis = direction_, .cone_rad = 4 * kInputRounding};
}

std::optional<LightParams> BeamLight::made_from() const { return params_; }

}  // namespace lucerna

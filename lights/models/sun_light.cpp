#include "lights/models/sun_light.h"

#include <limits>
#include <numbers>

#include "lights/maths/level_validation.h"
#include "lights/maths/validation.h"
#include "lights/models/all_lights.h"
#include "lights/models/irradiance.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/projected_solid_angle.h"
#include "lights/sampling/sampling.h"

namespace lucerna {

absl::StatusOr<SunLight> SunLight::create(const Params& params, const Vec3&) {
  if (auto s = check_direction("sun.to_light", params.to_light); !s.ok()) return s;
  const double diameter = params.angular_diameter_rad;
  if (!(diameter > 0 && diameter <= std::numbers::pi)) {
    return absl::InvalidArgumentError(
        fmt::format("sun.angular_diameter = {} rad, allowed (0, pi]", diameter));
  }
  if (auto s = check_light_value("sun.illuminance", params.illuminance_lx, "lx"); !s.ok()) {
    return s;
  }
  // One division at a time: the sine's square underflows before the quotient overflows.
  const double sin = std::sin(diameter / 2);
  const Rgb radiance = params.illuminance_lx.is_black()
                           ? Rgb{}
                           : params.illuminance_lx / std::numbers::pi / sin / sin;
  if (auto s = check_light_value("sun.illuminance / (pi sin^2(angular_diameter / 2))", radiance,
                                 "cd/m2");
      !s.ok()) {
    return s;
  }
  return SunLight(params, radiance);
}

SunLight::SunLight(const Params& params, const Rgb& radiance_cd_m2)
    : LightBeyond(/*leaves_freely=*/true, /*has_irradiance=*/true),
      params_(params),
      axis_(normalized(params.to_light)),
      unit_axis_(normalized(axis_)),
      radiance_cd_m2_(radiance_cd_m2) {
  const double s = std::sin(params.angular_diameter_rad / 4);
  one_minus_cos_ = 2 * s * s;
}

bool SunLight::contains(const Vec3& w) const {
  // 1 - cos of the angle between unit vectors is half the square of their chord, exact near the
  // axis.  Normalised first: directions of requests are floats, whose length is off by as much as
  // small suns are wide.
  const Vec3 chord = normalized(w) - unit_axis_;
  return dot(chord, chord) / 2 <= one_minus_cos_;
}

Vec3 SunLight::sample_direction(Vec2 u) const {
  const Vec3 local = sample_uniform_cone(Vec2{u.x, u.y}, one_minus_cos_);
  const Vec3 w = Frame::around(unit_axis_).world_from_local(local);
  if (contains(w)) return w;
  // If rounding led out of the disk, move inwards by a few roundings, or to the centre of a
  // narrower disk.
  const double inwards = 8 * std::numeric_limits<double>::epsilon();
  const double radius = params_.angular_diameter_rad / 2;
  if (radius > inwards) {
    const Vec3 inside = normalized(unit_axis_ + (w - unit_axis_) * (1 - inwards / radius));
    if (contains(inside)) return inside;
  }
  return axis_;
}

LightSample SunLight::sample_li(const Receiver& receiver, Vec2 u) const {
  LightSample sample;
  sample.pdf = {uniform_cone_pdf(one_minus_cos_).per_sr};
  if (!is_finite(receiver.position) || !std::isfinite(sample.pdf.per_sr)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  sample.wi = sample_direction(u);
  sample.distance = std::numeric_limits<double>::infinity();
  sample.value = Rgb(radiance_cd_m2_);
  if (sample.value.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

SolidAnglePdf SunLight::pdf_li(const Receiver& receiver, const Vec3& wi) const {
  if (!is_finite(receiver.position) || Rgb(radiance_cd_m2_).is_black()) return {};
  if (!contains(wi)) return {};
  const auto pdf = uniform_cone_pdf(one_minus_cos_).per_sr;
  return {std::isfinite(pdf) ? pdf : 0};
}

std::optional<Rgb> SunLight::irradiance(const Receiver& receiver) const {
  const double half = params_.angular_diameter_rad / 2;
  return irradiance_of(radiance_cd_m2_, receiver, [&](const Vec3& normal) {
    return cap_projected_solid_angle(unit_axis_, std::sin(half), std::cos(half), normal);
  });
}

Rgb SunLight::le_escaped(const Vec3&, const Vec3& w) const {
  return contains(w) ? Rgb(radiance_cd_m2_) : Rgb{};
}

Power SunLight::power(const SceneSphere& scene) const {
  if (params_.illuminance_lx.is_black()) return {};
  // L 2 pi (1 - cos h) pi R^2, where L = E / (pi (1 - cos h)(1 + cos h)).
  const double facing = 2 / (2 - one_minus_cos_);
  return {params_.illuminance_lx * scene.radius_m * scene.radius_m * (std::numbers::pi * facing),
          0};
}

Power SunLight::power_approximate(const SceneSphere& scene) const {
  if (params_.illuminance_lx.is_black()) return {};
  return approximate_power(
      params_.illuminance_lx * scene.radius_m * scene.radius_m * std::numbers::pi, power(scene));
}

EmissionSample SunLight::sample_le(Vec2 u_position, Vec2 u_direction,
                                   const SceneSphere& scene) const {
  EmissionSample sample;
  const Vec3 wi = sample_direction(u_direction);
  start_on_scene_disk(u_position, -normalized(wi), scene, sample);
  sample.direction = -wi;
  sample.pdf_direction = {uniform_cone_pdf(one_minus_cos_).per_sr};
  if (!std::isfinite(sample.pdf_direction.per_sr)) sample.reason = NoLight::kOutOfRange;
  if (radiance_cd_m2_.is_black()) sample.reason = NoLight::kBlack;
  if (sample.reason == NoLight::kNone) sample.value = Rgb(radiance_cd_m2_);
  if (sample.value.is_black() && sample.reason == NoLight::kNone) sample.reason = NoLight::kBlack;
  return sample;
}

EmissionPdf SunLight::pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                             double) const {
  const SolidAnglePdf pdf = pdf_li(Receiver(), -direction);
  if (!(pdf.per_sr > 0)) return {};
  const AreaPdf at = scene_disk_pdf(position, direction, scene);
  if (!(at.per_m2 > 0)) return {};
  return {at, pdf};
}

std::optional<LightParams> SunLight::made_from() const { return params_; }

}  // namespace lucerna

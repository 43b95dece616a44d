#include "lights/models/sun_light.h"

#include <limits>
#include <numbers>

#include "lights/maths/validation.h"
#include "lights/models/irradiance.h"
#include "lights/sampling/emission.h"
#include "lights/sampling/projected_solid_angle.h"
#include "lights/sampling/sampling.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {

template <std::floating_point Real>
absl::StatusOr<SunLight<Real>> SunLight<Real>::create(const Params& params, const Vec3<double>&) {
  if (auto s = check_direction("sun.to_light", params.to_light); !s.ok()) return s;
  const double diameter = params.angular_diameter_rad;
  if (!(diameter > 0 && diameter <= std::numbers::pi)) {
    return absl::InvalidArgumentError(
        fmt::format("sun.angular_diameter = {} rad, allowed (0, pi]", diameter));
  }
  if (auto s = check_light_value<Real>("sun.illuminance", params.illuminance_lx, "lx"); !s.ok()) {
    return s;
  }
  // One division at a time: the sine's square underflows before the quotient overflows.
  const double sin = std::sin(diameter / 2);
  const Rgb<double> radiance = params.illuminance_lx.is_black()
                                   ? Rgb<double>{}
                                   : params.illuminance_lx / std::numbers::pi / sin / sin;
  if (auto s = check_light_value<Real>("sun.illuminance / (pi sin^2(angular_diameter / 2))",
                                       radiance, "cd/m2");
      !s.ok()) {
    return s;
  }
  return SunLight(params, radiance);
}

template <std::floating_point Real>
SunLight<Real>::SunLight(const Params& params, const Rgb<double>& radiance_cd_m2)
    : params_(params),
      axis_(normalized(params.to_light)),
      unit_axis_(normalized(Vec3<double>(axis_))),
      radiance_cd_m2_(radiance_cd_m2) {
  const double s = std::sin(params.angular_diameter_rad / 4);
  one_minus_cos_ = 2 * s * s;
}

// Not inlined: GCC 12 at -O2 keeps a direction in double where it has just been rounded to float.
template <std::floating_point Real>
[[gnu::noinline]] bool SunLight<Real>::contains(const Vec3<Real>& w) const {
  // 1 - cos of the angle between unit vectors is half the square of their chord, exact near the
  // axis.  Normalised first: directions in floats differ from unit length by as much as small suns
  // are wide.
  const Vec3<double> chord = normalized(Vec3<double>(w)) - unit_axis_;
  return dot(chord, chord) / 2 <= one_minus_cos_;
}

template <std::floating_point Real>
Vec3<Real> SunLight<Real>::sample_direction(Vec2<Real> u) const {
  const Vec3<double> local = sample_uniform_cone(Vec2<double>{u.x, u.y}, one_minus_cos_);
  const Vec3<double> w = Frame<double>::around(unit_axis_).world_from_local(local);
  Vec3<Real> rounded(w);
  if (contains(rounded)) return rounded;
  // If rounding led out of the disk, move inwards by a few roundings, or to the centre of a
  // narrower disk.
  const double inwards = 8 * double{std::numeric_limits<Real>::epsilon()};
  const double radius = params_.angular_diameter_rad / 2;
  if (radius > inwards) {
    rounded = Vec3<Real>(normalized(unit_axis_ + (w - unit_axis_) * (1 - inwards / radius)));
    if (contains(rounded)) return rounded;
  }
  return axis_;
}

template <std::floating_point Real>
LightSample<Real> SunLight<Real>::sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const {
  LightSample<Real> sample;
  sample.pdf = {static_cast<Real>(uniform_cone_pdf(one_minus_cos_).per_sr)};
  if (!is_finite(receiver.position) || !std::isfinite(sample.pdf.per_sr)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  sample.wi = sample_direction(u);
  sample.distance = std::numeric_limits<Real>::infinity();
  sample.value = Rgb<Real>(radiance_cd_m2_);
  if (sample.value.is_black()) sample.reason = NoLight::kBlack;
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> SunLight<Real>::pdf_li(const Receiver<Real>& receiver,
                                           const Vec3<Real>& wi) const {
  if (!is_finite(receiver.position) || Rgb<Real>(radiance_cd_m2_).is_black()) return {};
  if (!contains(wi)) return {};
  const auto pdf = static_cast<Real>(uniform_cone_pdf(one_minus_cos_).per_sr);
  return {std::isfinite(pdf) ? pdf : 0};
}

template <std::floating_point Real>
std::optional<Rgb<Real>> SunLight<Real>::irradiance(const Receiver<Real>& receiver) const {
  const double half = params_.angular_diameter_rad / 2;
  return irradiance_of(radiance_cd_m2_, receiver, [&](const Vec3<double>& normal) {
    return cap_projected_solid_angle(unit_axis_, std::sin(half), std::cos(half), normal);
  });
}

template <std::floating_point Real>
Rgb<Real> SunLight<Real>::le_escaped(const Vec3<Real>&, const Vec3<Real>& w) const {
  return contains(w) ? Rgb<Real>(radiance_cd_m2_) : Rgb<Real>{};
}

template <std::floating_point Real>
Power SunLight<Real>::power(const SceneSphere& scene) const {
  if (params_.illuminance_lx.is_black()) return {};
  // L 2 pi (1 - cos h) pi R^2, where L = E / (pi (1 - cos h)(1 + cos h)).
  const double facing = 2 / (2 - one_minus_cos_);
  return {params_.illuminance_lx * scene.radius_m * scene.radius_m * (std::numbers::pi * facing),
          0};
}

template <std::floating_point Real>
Power SunLight<Real>::power_approximate(const SceneSphere& scene) const {
  if (params_.illuminance_lx.is_black()) return {};
  return approximate_power(
      params_.illuminance_lx * scene.radius_m * scene.radius_m * std::numbers::pi, power(scene));
}

template <std::floating_point Real>
EmissionSample<Real> SunLight<Real>::sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                               const SceneSphere& scene) const {
  EmissionSample<Real> sample;
  const Vec3<Real> wi = sample_direction(u_direction);
  start_on_scene_disk(u_position, -normalized(Vec3<double>(wi)), scene, sample);
  sample.direction = -wi;
  sample.pdf_direction = {static_cast<Real>(uniform_cone_pdf(one_minus_cos_).per_sr)};
  if (!std::isfinite(sample.pdf_direction.per_sr)) sample.reason = NoLight::kOutOfRange;
  if (radiance_cd_m2_.is_black()) sample.reason = NoLight::kBlack;
  if (sample.reason == NoLight::kNone) sample.value = Rgb<Real>(radiance_cd_m2_);
  if (sample.value.is_black() && sample.reason == NoLight::kNone) sample.reason = NoLight::kBlack;
  return sample;
}

template <std::floating_point Real>
EmissionPdf<Real> SunLight<Real>::pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                                         const SceneSphere& scene) const {
  const SolidAnglePdf<Real> pdf = pdf_li({0, 0, 0}, -direction);
  if (!(pdf.per_sr > 0)) return {};
  const AreaPdf<Real> at = scene_disk_pdf(position, direction, scene);
  if (!(at.per_m2 > 0)) return {};
  return {at, pdf};
}

template class SunLight<float>;
template class SunLight<double>;

}  // namespace lucerna

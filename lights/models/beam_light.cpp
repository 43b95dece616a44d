#include "lights/models/beam_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lights/maths/axes.h"
#include "lights/maths/validation.h"
#include "lights/sampling/emission.h"
#include "lights/shapes/shape.h"
#include "lights/spectra/level_validation.h"

namespace lucerna {
namespace {

/// From the middle to the corner of the smallest box with the largest coordinates.
Vec3<double> half_box(const BeamLightParams& params) {
  const Frame<double> axes = orthonormal(params.axes);
  const Vec3<double> x = axes.s * (params.width_m / 2), y = axes.t * (params.height_m / 2);
  return {std::fabs(x.x) + std::fabs(y.x), std::fabs(x.y) + std::fabs(y.y),
          std::fabs(x.z) + std::fabs(y.z)};
}

Rgb<double> brightest(const Image& image) {
  Rgb<double> most;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const Rgb<double> t(image.texel(x, y));
      most = {std::max(most.r, t.r), std::max(most.g, t.g), std::max(most.b, t.b)};
    }
  return most;
}

}  // namespace

std::pair<Vec3<double>, Vec3<double>> bounding_box(const BeamLightParams& params) {
  const Vec3<double> half = half_box(params);
  return {params.position_m - half, params.position_m + half};
}

template <std::floating_point Real>
absl::StatusOr<BeamLight<Real>> BeamLight<Real>::create(const Params& params,
                                                        const Vec3<double>& origin_m) {
  if (auto s = check_position<Real>("beam.position", params.position_m, origin_m); !s.ok())
    return s;
  if (auto s = check_right_angles("beam.axes", params.axes); !s.ok()) return s;
  // The square of a side and its reciprocal must fit `Real`.
  const double most = std::sqrt(double{std::numeric_limits<Real>::max()}) / 2;
  const double least = 2 * std::sqrt(double{std::numeric_limits<Real>::min()});
  for (const double side : {params.width_m, params.height_m})
    if (!(side >= least && side <= most))
      return absl::InvalidArgumentError(
          fmt::format("beam.width and height = {} and {} m, allowed: from {:.3g} to {:.3g}",
                      params.width_m, params.height_m, least, most));
  const auto [lower, upper] = bounding_box(params);
  for (const Vec3<double>& corner : {lower, upper})
    if (auto s = check_position<Real>("beam's corner", corner, origin_m); !s.ok()) return s;
  if (auto s = check_light_value<Real>("beam.illuminance", params.illuminance_lx, "lx"); !s.ok())
    return s;
  if (params.image) {
    if (auto s = check_light_value<Real>("beam.illuminance of the brightest texel",
                                         params.illuminance_lx * brightest(*params.image), "lx");
        !s.ok())
      return s;
  }
  return BeamLight(params, origin_m);
}

template <std::floating_point Real>
BeamLight<Real>::BeamLight(const Params& params, const Vec3<double>& origin_m)
    : params_(params),
      middle_(params.position_m - origin_m),
      axes_(orthonormal(params.axes)),
      direction_(axes_.n),
      mean_(params.image ? params.image->mean() : Rgb<double>(1)),
      mean_luminance_(luminance(mean_)) {
  if (params_.image)
    distribution_ = std::make_shared<const ImageDistribution>(*params_.image, params_.filter,
                                                              ImageBorder::kClamp);
}

template <std::floating_point Real>
std::optional<Vec2<double>> BeamLight<Real>::in_square(double x, double y, double slack_m) const {
  const double half_x = params_.width_m / 2, half_y = params_.height_m / 2;
  if (!(std::fabs(x) <= half_x + slack_m && std::fabs(y) <= half_y + slack_m)) return std::nullopt;
  return Vec2<double>{std::clamp((1 + x / half_x) / 2, 0.0, 1.0),
                      std::clamp((1 - y / half_y) / 2, 0.0, 1.0)};
}

// Not inlined: GCC 12 at -O2 keeps a position in double where it has just been rounded to float.
template <std::floating_point Real>
[[gnu::noinline]] std::optional<Vec2<double>> BeamLight<Real>::locate(const Vec3<Real>& position,
                                                                      double slack_m) const {
  if (!is_finite(position)) return std::nullopt;
  const Vec3<double> p(position);
  const Vec3<double> local = axes_.local_from_world(p - middle_);
  const double slack =
      slack_m + 4 * kInputRounding *
                    (max_abs(p) + max_abs(middle_) + std::max(params_.width_m, params_.height_m));
  if (!(std::fabs(local.z) <= slack)) return std::nullopt;
  return in_square(local.x, local.y, slack);
}

template <std::floating_point Real>
Rgb<double> BeamLight<Real>::value_at(const Vec2<double>& p) const {
  if (!params_.image) return params_.illuminance_lx;
  return params_.illuminance_lx * params_.image->lookup(p, params_.filter, ImageBorder::kClamp);
}

template <std::floating_point Real>
double BeamLight<Real>::per_m2(const Vec2<double>& p) const {
  return (distribution_ ? distribution_->pdf(p) : 1) / params_.width_m / params_.height_m;
}

template <std::floating_point Real>
LightSample<Real> BeamLight<Real>::sample_li(const Receiver<Real>& receiver, Vec2<Real>) const {
  LightSample<Real> sample;
  sample.delta = true;
  if (!is_finite(receiver.position)) {
    sample.reason = NoLight::kOutOfRange;
    return sample;
  }
  const Vec3<double> p(receiver.position);
  const Vec3<double> local = axes_.local_from_world(p - middle_);
  sample.wi = -direction_;
  if (local.z > 0) sample.distance = static_cast<Real>(local.z);
  sample.point = Vec3<Real>(p - axes_.n * local.z);
  if (is_black()) {
    sample.reason = NoLight::kBlack;
  } else if (!(local.z > 0)) {
    sample.reason = NoLight::kBehind;
  } else if (const auto at = in_square(local.x, local.y, 0); !at || value_at(*at).is_black()) {
    sample.reason = NoLight::kOutsideCone;
  } else if (const Rgb<Real> value(value_at(*at));
             !(sample.distance > 0 && std::isfinite(sample.distance)) || !is_finite(sample.point)) {
    sample.reason = NoLight::kOutOfRange;
  } else {
    sample.value = value;
  }
  return sample;
}

template <std::floating_point Real>
SolidAnglePdf<Real> BeamLight<Real>::pdf_li(const Receiver<Real>&, const Vec3<Real>&) const {
  return {};
}

template <std::floating_point Real>
EmissionSample<Real> BeamLight<Real>::sample_le(Vec2<Real> u_position, Vec2<Real>,
                                                const SceneSphere&) const {
  EmissionSample<Real> sample;
  sample.direction = direction_;
  if (is_black()) {
    sample.origin = Vec3<Real>(middle_);
    sample.reason = NoLight::kBlack;
    return sample;
  }
  Vec2<double> p{double{u_position.x}, double{u_position.y}};
  if (distribution_) p = distribution_->sample(p).position;
  sample.origin = Vec3<Real>(middle_ + axes_.s * ((p.x - 0.5) * params_.width_m) +
                             axes_.t * ((0.5 - p.y) * params_.height_m));
  // The density of the rounded position, as in pdf_le.
  const std::optional<Vec2<double>> rounded = locate(sample.origin);
  if (rounded) {
    sample.value = Rgb<Real>(value_at(*rounded));
    sample.pdf_position = {static_cast<Real>(per_m2(*rounded))};
  }
  settle(sample.pdf_position.per_m2, sample);
  return sample;
}

template <std::floating_point Real>
Rgb<Real> BeamLight<Real>::le_leaving(const Vec3<Real>& position, const Vec3<Real>&,
                                      double slack_m) const {
  const std::optional<Vec2<double>> p = locate(position, slack_m);
  return p ? Rgb<Real>(value_at(*p)) : Rgb<Real>{};
}

template <std::floating_point Real>
EmissionPdf<Real> BeamLight<Real>::pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                                          const SceneSphere&, double slack_m) const {
  if (is_black() || !same_direction(direction, direction_)) return {};
  const std::optional<Vec2<double>> p = locate(position, slack_m);
  if (!p) return {};
  return {{static_cast<Real>(per_m2(*p))}, {}};
}

template <std::floating_point Real>
Power BeamLight<Real>::power(const SceneSphere&) const {
  return {params_.illuminance_lx * mean_ * params_.width_m * params_.height_m, 0};
}

template <std::floating_point Real>
std::optional<LightBounds<Real>> BeamLight<Real>::bounds() const {
  const Vec3<double> half = half_box(params_);
  const auto [lower, upper] = rounded_outwards<Real>(middle_ - half, middle_ + half);
  // The cone has the size of the axis's rounding.
  return LightBounds<Real>{
      .lower = lower, .upper = upper, .axis = direction_, .cone_rad = 4 * kInputRounding};
}

template class BeamLight<float>;
template class BeamLight<double>;

}  // namespace lucerna

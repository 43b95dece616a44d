// The isotropic point light.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/models/inverse_square.h"
#include "lights/models/light_bounds.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct PointLightParams {
  Vec3<double> position_m{};   ///< world
  Rgb<double> intensity_cd{};  ///< per channel, finite, not negative
};

template <std::floating_point Real>
class PointLight {
 public:
  using Params = PointLightParams;
  static constexpr bool kDelta = true;

  /// Positions are kept relative to `origin_m`.  Errors: a field out of its domain.
  static absl::StatusOr<PointLight> create(const Params& params, const Vec3<double>& origin_m = {});

  /// Intensity over distance squared along `wi`.  kDegenerate where the receiver is the light's own
  /// position, kOutOfRange where the quotient is no finite number.  [Pharr23, 12.2]
  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> /*u*/) const {
    // Here, for loops over receivers to see it: a call takes longer than the light.
    LightSample<Real> sample;
    const Way way = find_way(position_, receiver.position, sample);
    if (sample.reason == NoLight::kNone) set_inverse_square(params_.intensity_cd, way, sample);
    return sample;
  }

  /// All that most samples say.  plain_sample_li tells it in a fraction of the time, with the bits
  /// of sample_li, where there is light and neither the square of the distance nor the value over-
  /// or underflows; nothing elsewhere.
  struct PlainSample {
    Vec3<Real> wi;
    Real distance;
    Rgb<Real> value;
  };
  std::optional<PlainSample> plain_sample_li(const Vec3<Real>& receiver) const {
    const auto way = plain_way<Real>(Vec3<double>(position_) - Vec3<double>(receiver));
    if (!way) return std::nullopt;
    const Rgb<Real> value(params_.intensity_cd / way->squared_m2);
    const Real sum = value.r + value.g + value.b;
    const auto distance = static_cast<Real>(way->distance_m);
    if (!(sum > 0) || !std::isfinite(sum) || !std::isfinite(distance)) return std::nullopt;
    return PlainSample{Vec3<Real>(way->wi), distance, value};
  }

  /// Delta: 0 everywhere.
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// Uniform over the sphere of directions; position certain.
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const;

  /// 4 pi I, exact.
  Power power(const SceneSphere& scene) const;
  /// The same: the book's formula is exact.  [Pharr23, 12.2]
  Power power_approximate(const SceneSphere& scene) const;

  std::optional<LightBounds<Real>> bounds() const;

  const Params& params() const { return params_; }
  const Vec3<Real>& position() const { return position_; }

 private:
  explicit PointLight(const Params& params, const Vec3<double>& origin_m);
  Params params_;
  Vec3<Real> position_;
};

}  // namespace lucerna

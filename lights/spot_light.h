// The spot light with pbrt-v4's edge: intensity I inside `falloff_start`, 0 outside
// `cone_half_angle`, and between them smoothstep of the cosine.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/light_bounds.h"
#include "lights/light_sample.h"

namespace lucerna {

struct SpotLightParams {
  Vec3<double> position_m{};     ///< world
  Vec3<double> axis{0, 0, 1};    ///< world, any length but 0: where the light points
  Rgb<double> intensity_cd{};    ///< on the axis, per channel, finite, not negative
  double cone_half_angle_rad{};  ///< (0, pi]: no light beyond
  double falloff_start_rad{};  ///< [0, cone_half_angle_rad]: full light within; equal: a hard edge
};

template <std::floating_point Real>
class SpotLight {
 public:
  using Params = SpotLightParams;
  static constexpr bool kDelta = true;

  static absl::StatusOr<SpotLight> create(const Params& params, const Vec3<double>& origin_m = {});

  /// Luminous intensity [cd] towards the unit vector `w` (world axes, from the light).  Zero
  /// outside the cone, continuous at its edge unless the edge is hard.  [Pharr23, 12.2.1]
  Rgb<Real> intensity(const Vec3<Real>& w) const;

  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// Directions in proportion to intensity; position certain.
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const;

  /// 2 pi I ((1 - cos s) + (cos s - cos c) / 2), the smoothstep's mean over the cosine being 1/2;
  /// exact.
  Power power(const SceneSphere& scene) const;

  /// The same: the book's formula is exact.  [Pharr23, 12.2.1]
  Power power_approximate(const SceneSphere& scene) const;

  std::optional<LightBounds<Real>> bounds() const;

  const Params& params() const { return params_; }

 private:
  explicit SpotLight(const Params& params, const Vec3<double>& origin_m);
  /// The share of the intensity towards the unit vector `w`, in [0, 1].
  double falloff(const Vec3<double>& w) const;
  /// The same of a direction as its type rounds it.
  double falloff_as_rounded(const Vec3<Real>& w) const;
  /// The integral of that share over directions [sr].
  double effective_sr() const;

  Params params_;
  Vec3<Real> position_;
  // In double, as the narrowest cones are no wider than the error of a direction in float.
  Vec3<double> axis_;
  double one_minus_cos_cone_, one_minus_cos_start_;
  double edge_;  ///< cos(falloff_start) - cos(cone_half_angle); 0 for a hard edge
};

}  // namespace lucerna

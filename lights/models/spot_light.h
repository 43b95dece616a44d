// The spot light: intensity I inside `falloff_start`, 0 outside `cone_half_angle`, and between them
// a profile of x = (cos theta - cos cone) / (cos start - cos cone).
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>

#include "lights/models/light_bounds.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

enum class SpotProfile : std::uint8_t {
  kSmoothstep,  ///< 3 x^2 - 2 x^3, as pbrt-v4 has it
  kQuartic,     ///< x^4, as pbrt-v1 to pbrt-v3 have it
};

struct SpotLightParams {
  Vec3<double> position_m{};     ///< world
  Vec3<double> axis{0, 0, 1};    ///< world, any length but 0: where the light points
  Rgb<double> intensity_cd{};    ///< on the axis, per channel, finite, not negative
  double cone_half_angle_rad{};  ///< (0, pi]: no light beyond
  double falloff_start_rad{};  ///< [0, cone_half_angle_rad]: full light within; equal: a hard edge
  SpotProfile profile = SpotProfile::kSmoothstep;
};

/// The integral of a spot's share of its intensity over directions [sr]: 2 pi ((1 - cos s) +
/// (cos s - cos c) m), m the profile's mean over x: 1/2 for smoothstep, 1/5 for x^4.  Exact.
double effective_solid_angle_sr(const SpotLightParams& params);

template <std::floating_point Real>
class SpotLight {
 public:
  using Params = SpotLightParams;
  static constexpr bool kDelta = true;

  static absl::StatusOr<SpotLight> create(const Params& params, const Vec3<double>& origin_m = {});

  /// Luminous intensity [cd] towards the unit vector `w` (world axes, from the light).  Zero
  /// outside the cone, continuous at its edge unless the edge is hard.  [Pharr23, 12.2.1]
  Rgb<Real> intensity(const Vec3<Real>& w) const;
  /// The same, as `value` of the ray that leaves the light towards `w`.
  Rgb<Real> le_leaving(const Vec3<Real>&, const Vec3<Real>& w) const { return intensity(w); }

  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// Directions in proportion to intensity; position certain.
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const;

  /// I times effective_solid_angle_sr(), exact.
  Power power(const SceneSphere& scene) const;

  /// 2 pi I (1 - (cos s + cos c) / 2) for either profile, as the books have it: exact for
  /// smoothstep, too high for x^4.  [Pharr23, 12.2.1]
  Power power_approximate(const SceneSphere& scene) const;

  std::optional<LightBounds<Real>> bounds() const;

  const Params& params() const { return params_; }

 private:
  explicit SpotLight(const Params& params, const Vec3<double>& origin_m);
  /// What `falloff` wants of a direction: as it was given where the cone, or the dark one about the
  /// back, is narrow, else unit.
  Vec3<double> told(const Vec3<double>& w) const { return is_narrow_ ? w : normalized(w); }
  /// The share of the intensity towards `w`, in [0, 1].
  double falloff(const Vec3<double>& w) const;
  /// Of the angle between the pole and `w`, of any length but 0: exact in all digits.
  double one_minus_cos_to_pole(const Vec3<double>& w) const;
  /// The same of a direction as its type rounds it.
  double falloff_as_rounded(const Vec3<Real>& w) const;

  Params params_;
  Vec3<Real> position_;
  // In double, as the narrowest cones are no wider than the error of a direction in float.
  Vec3<double> axis_;
  // The cone's edge is measured from the nearer end of the axis.
  bool is_wide_;       ///< beyond a right angle: that is the back
  Vec3<double> pole_;  ///< unit, the nearer end
  double to_cone_;     ///< 1 - cos of the angle between that and the edge
  /// Whether that angle is so small that the errors of unit vectors count: below a milliradian, of
  /// which they are 1e-13.
  bool is_narrow_;
  Vec3<double> pole_as_given_;  ///< but for a power of two
  double one_minus_cos_start_;
  double effective_sr_;
  double edge_;      ///< cos(falloff_start) - cos(cone_half_angle); 0 for a hard edge
  double per_edge_;  ///< 1 / edge_; 0 for a hard edge
};

}  // namespace lucerna

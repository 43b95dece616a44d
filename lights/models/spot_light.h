// The spot light.  Intensity is I inside `falloff_start` and 0 outside `cone_half_angle`.  Between
// them it is a profile of x = (cos theta - cos cone) / (cos start - cos cone).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "lights/models/intensity_light.h"

namespace lucerna {

enum class SpotProfile : std::uint8_t {
  kSmoothstep,  ///< 3 x^2 - 2 x^3, as in pbrt-v4
  kQuadratic,   ///< x^2, as in glTF
  kQuartic,     ///< x^4, as in pbrt-v1 to pbrt-v3
};

struct SpotLightParams {
  Vec3 position_m{};             ///< world
  Vec3 axis{0, 0, 1};            ///< world, any length but 0: where the light points
  Rgb intensity_cd{};            ///< on the axis, per channel, finite, not negative
  double cone_half_angle_rad{};  ///< (0, pi]: no light outside
  double falloff_start_rad{};  ///< [0, cone_half_angle_rad]: full light inside; equal: a hard edge
  SpotProfile profile = SpotProfile::kSmoothstep;
  std::shared_ptr<const Frame> own_space{};  ///< see Deformable

  Rgb& level() { return intensity_cd; }
  void apply(const LightMover& move) {
    move.point(position_m), move.direction(axis), move.frame(own_space);
  }
};

SpotLightParams in_space(SpotLightParams params, const Deformation& map);

/// The integral over directions of a spot's intensity relative to its axis [sr]:
/// 2 pi ((1 - cos s) + (cos s - cos c) m).  m is the mean of the profile over x: 1/2 for
/// smoothstep, 1/3 for x^2, 1/5 for x^4.  Exact.
double effective_solid_angle_sr(const SpotLightParams& params);

class SpotIntensity {
 public:
  using Params = SpotLightParams;

  explicit SpotIntensity(const Params& params);
  static absl::Status check(const Params& params, const Vec3& origin_m);

  /// Luminous intensity [cd] towards the unit vector `w`.  Zero outside the cone, continuous at its
  /// edge unless the edge is hard.  [Pharr23, 12.2.1]
  Rgb intensity(const Vec3& w) const;

  bool is_black() const { return params_.intensity_cd.is_black(); }
  std::optional<Rgb> towards(const Vec3& w, const Vec3& v) const;

  /// Directions in proportion to intensity.
  void sample(Vec2 u, EmissionSample& ray) const;
  double per_sr(const Vec3& w) const;

  /// I times effective_solid_angle_sr(), exact.
  Power power() const;
  /// 2 pi I (1 - (cos s + cos c) / 2) for each profile, as in the books.  Exact for smoothstep,
  /// too high for x^2 and x^4.  [Pharr23, 12.2.1]
  Power power_approximate() const;
  EmissionCone cone() const;

  std::uint64_t table_bytes() const { return 0; }
  SharedData shared_data() const { return {}; }

  const Params& params() const { return params_; }

 private:
  /// The form of a direction that `falloff` takes: `w` unchanged if the cone, or the dark cone
  /// around the back, is narrow.  Else a unit vector.
  Vec3 falloff_direction(const Vec3& w) const { return is_narrow_ ? w : normalized(w); }
  /// Intensity towards `w` relative to the axis, in [0, 1].
  double falloff(const Vec3& w) const;
  /// 1 - cos of the angle between the pole and `w`, of any length but 0.  Exact to rounding.
  double one_minus_cos_to_pole(const Vec3& w) const;

  Params params_;
  // In double: the narrowest cones are not wider than the error of a direction in float.
  Vec3 axis_;
  // The cone's edge is measured from the nearer end of the axis.
  bool is_wide_;    ///< the cone is wider than a right angle: the nearer end is the back
  Vec3 pole_;       ///< unit, the nearer end
  double to_cone_;  ///< 1 - cos of the angle between the pole and the edge
  /// Whether that angle is below a milliradian, so that the errors of unit vectors matter.  At a
  /// milliradian they are 1e-13 of the angle.
  bool is_narrow_;
  Vec3 pole_as_given_;  ///< scaled by a power of two only
  double one_minus_cos_start_;
  double effective_sr_;
  double edge_;      ///< cos(falloff_start) - cos(cone_half_angle); 0 for a hard edge
  double per_edge_;  ///< 1 / edge_; 0 for a hard edge
};

using SpotLight = IntensityLight<SpotIntensity>;
extern template class IntensityLight<SpotIntensity>;

}  // namespace lucerna

// The isotropic point light.
#pragma once

#include "lights/models/intensity_light.h"

namespace lucerna {

struct PointLightParams {
  Vec3 position_m{};   ///< world
  Rgb intensity_cd{};  ///< per channel, finite, not negative

  Rgb& level() { return intensity_cd; }
  void apply(const LightMover& move) { move.point(position_m); }
};

/// The same intensity in all directions.
class IsotropicProfile {
 public:
  using Params = PointLightParams;

  explicit IsotropicProfile(const Params& params) : params_(params) {}
  static absl::Status check(const Params& params, const Vec3& origin_m);

  bool is_black() const { return params_.intensity_cd.is_black(); }
  std::optional<Rgb> towards(const Vec3&, const Vec3&) const { return params_.intensity_cd; }
  const Rgb& intensity_cd() const { return params_.intensity_cd; }

  /// Uniform over the sphere of directions.
  void sample(Vec2 u, EmissionSample& ray) const;
  double per_sr(const Vec3& w) const;

  /// 4 pi I, exact.
  Power power() const;
  /// The same: the book's formula is exact.  [Pharr23, 12.2]
  Power power_approximate() const { return power(); }
  EmissionCone cone() const { return {.half_angle_rad = std::numbers::pi}; }

  std::uint64_t table_bytes() const { return 0; }
  SharedData shared_data() const { return {}; }

  const Params& params() const { return params_; }

 private:
  Params params_;
};

using PointLight = IntensityLight<IsotropicProfile>;
extern template class IntensityLight<IsotropicProfile>;

}  // namespace lucerna

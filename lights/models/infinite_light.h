// The uniform infinite light: radiance L from every direction that geometry does not block.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/models/irradiance.h"
#include "lights/models/light_model.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct UniformInfiniteLightParams {
  Rgb radiance_cd_m2{};  ///< per channel, finite, not negative
};

class UniformInfiniteLight {
 public:
  using Params = UniformInfiniteLightParams;
  static constexpr bool kDelta = false;
  static constexpr bool kHasIrradiance = true;
  static constexpr bool kSameForAllRays = true;

  static absl::StatusOr<UniformInfiniteLight> create(const Params& params,
                                                     const Vec3& origin_m = {});
  /// Uniform over the sphere, density 1 / (4 pi); distance infinite.
  LightSample sample_li(const Receiver& receiver, Vec2 u) const;
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const;
  /// Irradiance without occlusion on the side that `receiver` faces, pi L [lx].  Nothing if the
  /// receiver has no normal or is not finite.
  std::optional<Rgb> irradiance(const Receiver& receiver) const;
  bool hides_itself() const { return false; }
  MostIrradiance most_irradiance(const Receiver& receiver) const {
    return most_from_beyond(*this, receiver);
  }
  /// Radiance [cd/m2] that a ray from `origin` meets when it leaves the scene towards `w`.
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const;
  /// Flux through the disk of the scene's sphere from all directions, 4 pi L pi R^2.
  Power power(const SceneSphere& scene) const;
  /// The same: the book has this formula.  [Pharr23, 12.5]
  Power power_approximate(const SceneSphere& scene) const;
  /// Uniform over directions, from the disk of the scene's sphere that faces each.
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction, const SceneSphere& scene) const;
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene) const;
  /// None: it is infinitely far.
  std::optional<LightBounds> bounds() const { return std::nullopt; }
  std::optional<double> cross_section_m2(const SceneSphere& scene) const {
    return scene_disk_area_m2(scene);
  }
  static LightPlace place(const Params&) { return {}; }
  LightBytes own_bytes() const { return {}; }
  template <typename F>
  void for_each_shared(F&&) const {}
  const Params& params() const { return params_; }

 private:
  explicit UniformInfiniteLight(const Params& params);
  Params params_;
  Rgb radiance_;
};

}  // namespace lucerna

// The uniform infinite light: radiance L from every direction that geometry does not block.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/models/irradiance.h"
#include "lights/models/light.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct UniformInfiniteLightParams {
  Rgb radiance_cd_m2{};  ///< per channel, finite, not negative

  Rgb& level() { return radiance_cd_m2; }
  void apply(const LightMover&) {}
};

class UniformInfiniteLight final : public LightBeyond {
 public:
  using Params = UniformInfiniteLightParams;
  using LightBeyond::pdf_li;

  static absl::StatusOr<UniformInfiniteLight> create(const Params& params,
                                                     const Vec3& origin_m = {});
  /// Uniform over the sphere, density 1 / (4 pi); distance infinite.
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override;
  /// Irradiance without occlusion on the side that `receiver` faces, pi L [lx].  Nothing if the
  /// receiver has no normal or is not finite.
  std::optional<Rgb> irradiance(const Receiver& receiver) const override;
  MostIrradiance most_irradiance(const Receiver& receiver) const override {
    return most_from_beyond(*this, receiver);
  }
  /// Radiance [cd/m2] that a ray from `origin` meets when it leaves the scene towards `w`.
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const override;
  Rgb le_leaving(const Vec3&, const Vec3&, double) const override { return {}; }
  /// Flux through the disk of the scene's sphere from all directions, 4 pi L pi R^2.
  Power power(const SceneSphere& scene) const override;
  /// The same: the book has this formula.  [Pharr23, 12.5]
  Power power_approximate(const SceneSphere& scene) const override;
  /// Uniform over directions, from the disk of the scene's sphere that faces each.
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                     double slack_m = 0) const override;
  std::optional<double> cross_section_m2(const SceneSphere& scene) const override {
    return scene_disk_area_m2(scene);
  }
  static LightPlace place(const Params&) { return {}; }
  LightBytes own_bytes() const override { return {.object = sizeof *this}; }
  SharedData shared_data() const override { return {}; }
  std::optional<LightParams> made_from() const override;
  const Params& params() const { return params_; }

 private:
  explicit UniformInfiniteLight(const Params& params);
  Params params_;
  Rgb radiance_;
};

}  // namespace lucerna

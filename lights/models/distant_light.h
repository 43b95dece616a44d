// The distant light: parallel rays from one direction.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/models/light.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct DistantLightParams {
  Vec3 to_light{0, 0, 1};  ///< world, any length but 0: from the scene to the light
  Rgb illuminance_lx{};    ///< on a surface that faces it, per channel, finite, not negative

  Rgb& level() { return illuminance_lx; }
  void apply(const LightMover& move) { move.direction(to_light); }
};

class DistantLight final : public DeltaLight {
 public:
  using Params = DistantLightParams;

  static absl::StatusOr<DistantLight> create(const Params& params, const Vec3& origin_m = {});
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;
  /// Flux through the disk of the scene's sphere, E pi R^2.
  Power power(const SceneSphere& scene) const override;
  /// The same: the book has this formula.  [Pharr23, 12.3]
  Power power_approximate(const SceneSphere& scene) const override;
  /// From the disk of the scene's sphere that faces the light.  The direction is certain.
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  Rgb le_leaving(const Vec3&, const Vec3&, double) const override { return {}; }
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                     double slack_m = 0) const override;
  /// None: it is infinitely far.
  std::optional<LightBounds> bounds() const override { return std::nullopt; }
  std::optional<double> cross_section_m2(const SceneSphere& scene) const override {
    return scene_disk_area_m2(scene);
  }
  static LightPlace place(const Params&) { return {}; }
  LightBytes own_bytes() const override { return {.object = sizeof *this}; }
  SharedData shared_data() const override { return {}; }
  std::optional<LightParams> made_from() const override;
  const Params& params() const { return params_; }

 private:
  explicit DistantLight(const Params& params);
  Params params_;
  Vec3 to_light_;
  Rgb illuminance_;
};

}  // namespace lucerna

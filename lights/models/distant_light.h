// The distant light: parallel rays from one direction.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/models/light_model.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct DistantLightParams {
  Vec3 to_light{0, 0, 1};  ///< world, any length but 0: from the scene to the light
  Rgb illuminance_lx{};    ///< on a surface that faces it, per channel, finite, not negative
};

class DistantLight {
 public:
  using Params = DistantLightParams;
  static constexpr bool kDelta = true;
  static constexpr bool kSameForAllRays = true;

  static absl::StatusOr<DistantLight> create(const Params& params, const Vec3& origin_m = {});
  LightSample sample_li(const Receiver& receiver, Vec2 u) const;
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const;
  /// Flux through the disk of the scene's sphere, E pi R^2.
  Power power(const SceneSphere& scene) const;
  /// The same: the book has this formula.  [Pharr23, 12.3]
  Power power_approximate(const SceneSphere& scene) const;
  /// From the disk of the scene's sphere that faces the light.  The direction is certain.
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
  explicit DistantLight(const Params& params);
  Params params_;
  Vec3 to_light_;
  Rgb illuminance_;
};

}  // namespace lucerna

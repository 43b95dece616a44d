// The sun: a disk of uniform radiance at infinity, seen under an angle.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lights/models/irradiance.h"
#include "lights/models/light.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct SunLightParams {
  Vec3 to_light{0, 0, 1};         ///< world, any length but 0: from the scene to its centre
  double angular_diameter_rad{};  ///< (0, pi]
  /// On a surface that faces its centre without occlusion, per channel, finite, not negative.
  Rgb illuminance_lx{};

  Rgb& level() { return illuminance_lx; }
  void apply(const LightMover& move) { move.direction(to_light); }
};

class SunLight final : public LightBeyond {
 public:
  using Params = SunLightParams;
  using LightBeyond::pdf_li;

  /// Errors: a field out of its domain; a radiance that does not fit `double`.
  static absl::StatusOr<SunLight> create(const Params& params, const Vec3& origin_m = {});

  /// Uniform over the disk's solid angle.  The radiance of a disk of half angle h that gives the
  /// illuminance E on a surface facing its centre is E / (pi sin^2 h).
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override;
  /// Irradiance without occlusion on the side that `receiver` faces [lx].  Nothing if the receiver
  /// has no normal or is not finite.
  std::optional<Rgb> irradiance(const Receiver& receiver) const override;
  MostIrradiance most_irradiance(const Receiver& receiver) const override {
    return most_from_beyond(*this, receiver);
  }
  /// Radiance [cd/m2] that a ray leaving the scene towards `w` meets.
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const override;
  /// The same for a ray that enters the scene towards `w`.
  Rgb le_leaving(const Vec3& origin, const Vec3& w, double = 0) const override {
    return le_escaped(origin, -w);
  }

  /// Flux through the disk of the scene's sphere, which faces each of the sun's directions:
  /// radiance times solid angle times pi R^2.
  Power power(const SceneSphere& scene) const override;
  /// The flux as if all light came from the centre, E pi R^2.  [Pharr23, 12.3]
  Power power_approximate(const SceneSphere& scene) const override;
  /// From the disk of the scene's sphere that faces each direction.
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
  explicit SunLight(const Params& params, const Rgb& radiance_cd_m2);
  /// Whether `w`, of any length but 0, meets the disk.
  bool contains(const Vec3& w) const;
  /// Towards the disk.
  Vec3 sample_direction(Vec2 u) const;

  Params params_;
  Vec3 axis_;
  Vec3 unit_axis_;  ///< of the axis rounded to `double`, so that even the narrowest cone
                    ///< contains the axis
  double one_minus_cos_;
  Rgb radiance_cd_m2_;
};

}  // namespace lucerna

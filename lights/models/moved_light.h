// A moving light at one moment, evaluated where it stands at its first key frame.
#pragma once

#include <optional>

#include "lights/maths/motion.h"
#include "lights/models/light.h"

namespace lucerna {

/// A light under a rigid map.  The inverse of `pose` takes receivers to the light's space, and
/// `pose` takes samples back.  Each of the two rounds once.  Under the identity, all results but
/// `bounds` have the bits of the light.  Refers to the light, which must outlive it.
class MovedLight final : public Light {
 public:
  MovedLight(const Light& light, const Pose& pose)
      : Light(light.traits()), light_(light), pose_(pose) {}

  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override;
  SolidAnglePdf pdf_li(const Receiver& receiver, const SurfacePoint& point) const override;
  std::optional<Rgb> irradiance(const Receiver& receiver) const override;
  bool hides_itself() const override { return light_.hides_itself(); }
  MostIrradiance most_irradiance(const Receiver& receiver) const override;
  Rgb le(const SurfacePoint& point, const Vec3& w) const override;
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const override;
  Rgb le_leaving(const Vec3& origin, const Vec3& w, double slack_m = 0) const override;
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  EmissionSample ray_from(const SurfacePoint& point, const Vec3& w,
                          double slack_m = 0) const override;
  /// Positions count as on the light if they are within their own rounding of it.  This is the
  /// rounding at the light's present position.  It may be much larger than the rounding of the
  /// light about its own origin.
  EmissionPdf pdf_le(const Vec3& position, const Vec3& w, const SceneSphere& scene,
                     double slack_m = 0) const override;
  Power power(const SceneSphere& scene) const override;
  Power power_approximate(const SceneSphere& scene) const override;
  /// The bounds of the light.  The box turns with it and is enclosed by a box along the axes.  Box
  /// and cone are larger by the possible rounding.
  std::optional<LightBounds> bounds() const override;
  std::optional<double> cross_section_m2(const SceneSphere& scene) const override;
  LightBytes own_bytes() const override { return {}; }
  SharedData shared_data() const override { return light_.shared_data(); }
  /// Those of the light at its first key frame.
  std::optional<LightParams> made_from() const override;

 private:
  EmissionSample from_light(EmissionSample s) const;
  Receiver to_light(const Receiver& receiver) const;
  SurfacePoint to_light(const SurfacePoint& p) const;
  SceneSphere to_light(const SceneSphere& scene) const;

  const Light& light_;
  Pose pose_;
};

}  // namespace lucerna

// The infinite light whose radiance comes from a picture around the scene.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <string>

#include "lights/maths/deformation.h"
#include "lights/maths/transform.h"
#include "lights/models/light.h"
#include "lights/pictures/sphere_map.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct ImageInfiniteLightParams {
  std::shared_ptr<const SphereMap> map;
  std::string image_name{};    ///< reported by ListLights, else unused
  Transform world_from_map{};  ///< its translation is not used
  Rgb radiance_cd_m2{1.0};     ///< of a texel of value 1, per channel, finite, not negative

  Rgb& level() { return radiance_cd_m2; }
  void apply(const LightMover& move) { move.rotation(world_from_map); }
};

class ImageInfiniteLight final : public LightBeyond {
 public:
  using Params = ImageInfiniteLightParams;
  using LightBeyond::pdf_li;

  /// Errors: no map; a transform that flattens directions; a radiance that is negative or not
  /// finite; a brightest texel beyond the range of `double`.
  static absl::StatusOr<ImageInfiniteLight> create(const Params& params, const Vec3& origin_m = {});

  /// A direction by the map's luminance, with the density of SphereDistribution; distance infinite.
  /// For an `incomplete` receiver, by max(0, luminance - mean luminance).  This is 0 where the
  /// directions that the caller samples are as good.  A map that is nowhere above its mean uses
  /// its luminance.  [Karlik19]
  ///
  /// Value and density belong to the rounded `wi`, which at a pole may show another texel. kBlack
  /// where the map or the radiance is black.  kOutsideCone if rounding leads into the dark.
  /// kOutOfRange where value or density is not a positive normal `double`.  [Karlik19]
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override;
  std::optional<Rgb> irradiance(const Receiver&) const override { return std::nullopt; }
  /// Upper bounds of the illuminance on the side that `receiver` faces: the integral of the map,
  /// times the largest cosine.
  MostIrradiance most_irradiance(const Receiver& receiver) const override;
  /// Radiance [cd/m2] that a ray from anywhere meets when it leaves the scene towards the unit
  /// vector `w`.
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const override;
  /// The same for a ray that enters the scene towards `w`.
  Rgb le_leaving(const Vec3& origin, const Vec3& w, double = 0) const override {
    return le_escaped(origin, -w);
  }

  /// From the disk of the scene's sphere that faces the sampled direction; kDegenerate where the
  /// sphere has no extent.
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                     double slack_m = 0) const override;

  /// Flux through the disk of the scene's sphere from all directions: pi R^2 times the integral of
  /// the radiance, exact.  Under unequal scale, a sum over directions with the difference to a
  /// coarser sum as its error.
  Power power(const SceneSphere& scene) const override;
  /// Equal-area maps: 4 pi^2 R^2 times the mean texel, which is exact.  Latitude-longitude maps: pi
  /// R^2 times the mean texel, as in pbrt-v2 and pbrt-v3.  These omit the 4 pi of the sphere and
  /// the sines of the rows.
  Power power_approximate(const SceneSphere& scene) const override;

  std::optional<double> cross_section_m2(const SceneSphere& scene) const override {
    return scene_disk_area_m2(scene);
  }
  static LightPlace place(const Params&) { return {}; }
  const Params& params() const { return params_; }
  /// The tables that it samples.
  LightBytes own_bytes() const override;
  SharedData shared_data() const override { return {.image = &params_.map->image()}; }
  std::optional<LightParams> made_from() const override;

 private:
  /// Set under unequal scale.
  struct Deformed {
    Deformation map;
    Rgb integral;  ///< of the map over the directions of the world [sr]
    double error;  ///< of its luminance
  };

  ImageInfiniteLight(const Params& params, std::shared_ptr<const Deformed> deformed);
  /// The unit direction in the map's axes; NaN where `w` is not finite.
  Vec3 map_from_world(const Vec3& w) const {
    return deformed_ ? normalized(deformed_->map.own_from_world(w)) : axes_.map_from_world(w);
  }
  /// The density of a direction of the world whose direction in the map is `in_map`.
  double per_sr(const SphereDistribution& distribution, const Vec3& w, const Vec3& in_map) const {
    const double density = distribution.per_sr(in_map);
    return deformed_ ? density * deformed_->map.own_sr_per_world_sr(normalized(w)) : density;
  }
  /// Values of a direction after rounding to `double`.
  struct Seen {
    Rgb radiance;
    double per_sr;
  };
  Seen look(const SphereDistribution& distribution, const Vec3& w) const;
  const SphereDistribution& distribution(const Receiver& receiver) const {
    return receiver.incomplete ? *compensated_ : *complete_;
  }

  Params params_;
  MapAxes axes_;
  std::shared_ptr<const Deformed> deformed_;
  std::shared_ptr<const SphereDistribution> complete_, compensated_;
};

}  // namespace lucerna

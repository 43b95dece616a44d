// A picture of intensity by direction: one number for each texel.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>

#include "lights/maths/emission_cone.h"
#include "lights/pictures/sphere_map.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

/// Whether the three channels of each texel are the same.
bool is_grey(const Image& image);

/// A texel's value is the mean of its channels, as in pbrt-v4.  All numbers here are for a light in
/// which a value of 1 is 1 cd.  Directions are in the map's own axes (see SphereMapping).
/// Immutable; lights share it.
class IntensityMap {
 public:
  /// An image without colours is shared, not copied.  Errors: those of SphereMap.
  static absl::StatusOr<std::shared_ptr<const IntensityMap>> create(
      std::shared_ptr<const Image> image, SphereMapping mapping, ImageFilter filter);

  /// Luminous intensity [cd] towards `w`, of any length but 0.
  double at(const Vec3& w) const;

  /// Luminous flux [lm]: the integral of `at` over the sphere, closed form.
  double flux_lm() const { return map_->integral().r; }
  /// The largest intensity [cd].
  double max_cd() const { return max_cd_; }
  /// The mean over the picture [cd].  For equal-area maps, it is also the mean over the sphere.
  double mean_cd() const { return map_->image().mean().r; }

  /// A unit direction by the density of SphereDistribution.  Undefined where the flux is 0.
  Vec3 sample(Vec2 u) const { return distribution_.sample(u).direction; }
  /// The density of `sample`: positive wherever the intensity is.
  SolidAnglePdf pdf(const Vec3& w) const;

  /// The cone around the mean direction of the flux that holds all light.
  const EmissionCone& cone() const { return cone_; }

  const SphereMap& sphere_map() const { return *map_; }
  /// Memory without the picture.
  std::uint64_t table_bytes() const { return sizeof(*this) + distribution_.bytes(); }

 private:
  explicit IntensityMap(std::shared_ptr<const SphereMap> map);
  void bound();

  std::shared_ptr<const SphereMap> map_;
  SphereDistribution distribution_;
  double max_cd_ = 0;
  EmissionCone cone_;
};

}  // namespace lucerna

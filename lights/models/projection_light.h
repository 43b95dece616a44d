// The projection light: a picture, or an evenly lit rectangle, projected from a point, as a slide
// projector does.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "lights/models/intensity_light.h"
#include "lights/pictures/projected_picture.h"

namespace lucerna {

struct ProjectionLightParams {
  Vec3 position_m{};  ///< world
  /// World directions, of any lengths but 0 and at right angles.  They point to the picture's right
  /// edge, to its upper edge, and where the light points.
  Frame axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::shared_ptr<const ProjectedPicture> picture{};
  Rgb intensity_cd{};        ///< where the picture's value is 1, finite, not negative
  std::string image_name{};  ///< reported by ListLights, else unused
  std::shared_ptr<const Frame> own_space{};  ///< see Deformable

  Rgb& level() { return intensity_cd; }
  void apply(const LightMover& move) {
    move.point(position_m), move.frame(axes), move.frame(own_space);
  }
};

ProjectionLightParams in_space(ProjectionLightParams params, const Deformation& map);

class ProjectionIntensity {
 public:
  using Params = ProjectionLightParams;

  explicit ProjectionIntensity(const Params& params);
  /// Errors: no picture; a field out of its domain; the intensity of the brightest texel out of its
  /// domain.
  static absl::Status check(const Params& params, const Vec3& origin_m);

  /// Luminous intensity [cd] towards the unit vector `w`: `intensity_cd` times the picture's value
  /// there, 0 beside it.  [Pharr23, 12.2.2]
  Rgb intensity(const Vec3& w) const;

  bool is_black() const { return params_.intensity_cd.is_black() || params_.picture->empty(); }
  std::optional<Rgb> towards(const Vec3& w, const Vec3& v) const;

  /// Directions as ProjectedPicture samples them.
  void sample(Vec2 u, EmissionSample& ray) const;
  double per_sr(const Vec3& w) const;

  /// The integral of the picture over solid angle, texel by texel.  For the bilinear filter: cell
  /// by cell, to a relative error of 1e-14.
  Power power() const;
  /// With a picture, as in pbrt-v4: a texel's solid angle is its area in the plane times cos^3 at
  /// its centre.  Without a picture, as in pbrt-v3: the cone around the rectangle, which is too
  /// high.
  Power power_approximate() const;
  /// The cone around the picture's corners.
  EmissionCone cone() const;

  std::uint64_t table_bytes() const { return params_.picture->bytes(); }
  SharedData shared_data() const { return {.image = params_.picture->params().image.get()}; }

  const Params& params() const { return params_; }

 private:
  /// The picture's value towards `w`, of any length but 0, world axes.
  Rgb value_at(const Vec3& w) const;

  Params params_;
  Frame axes_;  ///< of length 1
};

using ProjectionLight = IntensityLight<ProjectionIntensity>;
extern template class IntensityLight<ProjectionIntensity>;

}  // namespace lucerna

// The projection light: a picture, or an evenly lit rectangle, thrown from a point, as a slide
// projector does.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <string>

#include "lights/models/light_bounds.h"
#include "lights/pictures/projected_picture.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct ProjectionLightParams {
  Vec3<double> position_m{};  ///< world
  /// World directions, of any lengths but 0 and at right angles: the picture's right, its upper
  /// edge, and where the light points.
  Frame<double> axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::shared_ptr<const ProjectedPicture> picture{};
  Rgb<double> intensity_cd{};  ///< where the picture's value is 1, finite, not negative
  std::string image_name{};    ///< told by ListLights, else unused
};

template <std::floating_point Real>
class ProjectionLight {
 public:
  using Params = ProjectionLightParams;
  static constexpr bool kDelta = true;

  /// Errors: no picture; a field out of its domain, the intensity of the brightest texel too.
  static absl::StatusOr<ProjectionLight> create(const Params& params,
                                                const Vec3<double>& origin_m = {});

  /// Luminous intensity [cd] towards the unit vector `w` (world axes, from the light): that of
  /// `intensity_cd` times the picture's value there, 0 beside it.  [Pharr23, 12.2.2]
  Rgb<Real> intensity(const Vec3<Real>& w) const;
  /// The same, as `value` of the ray that leaves the light towards `w`.
  Rgb<Real> le_leaving(const Vec3<Real>&, const Vec3<Real>& w) const { return intensity(w); }

  /// Intensity over distance squared.  kOutsideCone beside the picture and where it is black.
  LightSample<Real> sample_li(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// Delta: 0 everywhere.
  SolidAnglePdf<Real> pdf_li(const Receiver<Real>& receiver, const Vec3<Real>& wi) const;

  /// Directions as ProjectedPicture has them; position certain.
  EmissionSample<Real> sample_le(Vec2<Real> u_position, Vec2<Real> u_direction,
                                 const SceneSphere& scene) const;
  EmissionPdf<Real> pdf_le(const Vec3<Real>& position, const Vec3<Real>& direction,
                           const SceneSphere& scene) const;

  /// The integral of the picture over solid angle, texel by texel (cell by cell for the bilinear
  /// filter, to 1e-14).
  Power power(const SceneSphere& scene) const;
  /// With a picture as pbrt-v4 has it: a texel's solid angle is its area in the plane times cos^3
  /// at its centre.  Without one as pbrt-v3 has it: that of the cone about the rectangle, too high.
  Power power_approximate(const SceneSphere& scene) const;

  /// A point; the cone about the picture's corners.
  std::optional<LightBounds<Real>> bounds() const;

  const Params& params() const { return params_; }
  /// Of what was made for sampling.
  std::size_t table_bytes() const { return params_.picture->bytes(); }

 private:
  explicit ProjectionLight(const Params& params, const Vec3<double>& origin_m);
  /// The picture's value towards `w`, of any length but 0, world axes.
  Rgb<double> value_at(const Vec3<double>& w) const;
  /// Value and density of a direction as its type rounds it.
  struct Rounded {
    Rgb<double> value;
    double per_sr;
  };
  Rounded at_rounded(const Vec3<Real>& w) const;
  bool is_black() const { return params_.intensity_cd.is_black() || params_.picture->empty(); }

  Params params_;
  Vec3<Real> position_;
  Frame<double> axes_;  ///< of length 1
};

extern template class ProjectionLight<float>;
extern template class ProjectionLight<double>;

}  // namespace lucerna

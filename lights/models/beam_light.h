// The beam: parallel rays from a rectangle, with a picture or uniform.  It is the projection light
// with an orthographic projection.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <string>

#include "lights/models/light.h"
#include "lights/pictures/image.h"
#include "lights/pictures/image_distribution.h"
#include "lights/sampling/light_sample.h"

namespace lucerna {

struct BeamLightParams {
  Vec3 position_m{};  ///< the rectangle's middle, world
  /// World directions, of any lengths but 0 and at right angles.  They point to the rectangle's
  /// right edge, to its upper edge, and where the light points.
  Frame axes{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double width_m{}, height_m{};                ///< positive
  Rgb illuminance_lx{};                        ///< on a surface that faces it, where the picture's
                                               ///< value is 1; finite, not negative
  std::shared_ptr<const Image> image{};        ///< null: value 1 all over
  ImageFilter filter = ImageFilter::kNearest;  ///< the border texels continue
  std::string image_name{};                    ///< reported by ListLights, else unused

  Rgb& level() { return illuminance_lx; }
  void apply(const LightMover& move) { move.point(position_m), move.frame(axes); }
};

/// The smallest box around the rectangle: world [m].
Bounds bounding_box(const BeamLightParams& params);

/// The direction of its rays is certain.  Their start is not.
class BeamLight final : public DeltaLight {
 public:
  using Params = BeamLightParams;

  /// Errors: a field out of its domain; corners that `double` cannot hold; the illuminance of the
  /// brightest texel out of its domain.
  static absl::StatusOr<BeamLight> create(const Params& params, const Vec3& origin_m = {});

  /// The illuminance at the receiver's place in the rectangle, at any distance along the beam.
  /// `point` is the ray's start in the rectangle.  kBehind behind the rectangle and in its plane.
  /// kOutsideCone beside the beam and where the picture is black.
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;

  /// A position in the rectangle by luminance, with the exact density for the filter.  The
  /// direction is certain.
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  /// Illuminance [lx] that a ray from `position` carries; 0 beside the rectangle, as in pdf_le.
  Rgb le_leaving(const Vec3& position, const Vec3& direction, double slack_m = 0) const override;
  /// Both 0 where `position` is not in the rectangle, to within rounding and `slack_m`.
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                     double slack_m = 0) const override;

  /// Illuminance times area times the picture's mean; exact for either filter.
  Power power(const SceneSphere& scene) const override;
  /// The same: books have no other formula.
  Power power_approximate(const SceneSphere& scene) const override { return power(scene); }

  /// The rectangle's box and one direction, to within rounding.
  std::optional<LightBounds> bounds() const override;

  /// The rectangle's area.
  std::optional<double> cross_section_m2(const SceneSphere&) const override {
    return params_.width_m * params_.height_m;
  }
  static LightPlace place(const Params& params) {
    return {.anchor_m = params.position_m, .box_m = bounding_box(params)};
  }
  const Params& params() const { return params_; }
  /// The table from which positions are drawn.
  LightBytes own_bytes() const override {
    const std::uint64_t tables = distribution_ ? distribution_->bytes() : 0;
    return {.object = sizeof *this, .data = tables, .tables = tables};
  }
  SharedData shared_data() const override { return {.image = params_.image.get()}; }
  std::optional<LightParams> made_from() const override;

 private:
  explicit BeamLight(const Params& params, const Vec3& origin_m);
  /// The point of the unit square at `x` and `y` [m] from the middle; (0, 0) is the upper left
  /// corner.  Nothing if it is more than `slack_m` outside of the rectangle.
  std::optional<Vec2> in_square(double x, double y, double slack_m) const;
  /// The same for a position on the light, to within the rounding of its coordinates and `slack_m`.
  std::optional<Vec2> locate(const Vec3& position, double slack_m = 0) const;
  Rgb value_at(const Vec2& p) const;
  double per_m2(const Vec2& p) const;
  bool is_black() const { return params_.illuminance_lx.is_black() || !(mean_luminance_ > 0); }

  Params params_;
  Vec3 middle_;  ///< about the scene's origin
  Frame axes_;   ///< of length 1
  Vec3 direction_;
  Rgb mean_;  ///< of the picture
  double mean_luminance_;
  std::shared_ptr<const ImageDistribution> distribution_;  ///< null without a picture
};

}  // namespace lucerna

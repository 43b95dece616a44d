// The infinite light that enters through a rectangular opening only, such as the sky through a
// window.  Its radiance comes from a picture around the scene or is uniform.
#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "lights/maths/transform.h"
#include "lights/models/light.h"
#include "lights/pictures/map_illuminance.h"
#include "lights/pictures/sphere_map.h"
#include "lights/sampling/light_sample.h"
#include "lights/sampling/windowed_distribution.h"

namespace lucerna {

class RectifiedMap;

struct PortalLightParams {
  std::shared_ptr<const SphereMap> map{};  ///< null: the same radiance from all directions
  std::string image_name{};                ///< reported by ListLights, else unused
  /// True: uses a RectifiedMap of the map, as pbrt-v4 does.  False: the map itself.
  bool rectified = false;
  Transform world_from_map{};  ///< of equal scale, or `rectified`; its translation is not used
  Rgb radiance_cd_m2{1.0};     ///< of a texel of value 1, per channel, finite, not negative
  /// World, in order around the rectangle.  Light comes from the side to which cross(corner 3 -
  /// corner 0, corner 1 - corner 0) points.
  std::array<Vec3, 4> corners_m{};

  Rgb& level() { return radiance_cd_m2; }
  void apply(const LightMover& move) {
    for (Vec3& corner : corners_m) move.point(corner);
    move.rotation(world_from_map);
  }
};

/// A receiver sees a rectangle of the directions (tan alpha, tan beta, 1) in the portal's axes,
/// with sides along alpha and beta.  It samples that window of a table over both angles.
/// [Bitterli15]
class PortalLight final : public LightBeyond {
 public:
  using Params = PortalLightParams;
  using LightBeyond::pdf_li;
  /// How far each corner may be from a rectangle, relative to its shorter side.  The light uses the
  /// rectangle with the same centre and the mean of opposite edges.
  static constexpr double kRectangleTolerance = 1e-3;

  /// Errors: corners that do not form a rectangle, have no extent, or do not fit `double`; a
  /// transform of unequal scale without `rectified`; a radiance that is negative or not finite; a
  /// brightest texel that does not fit `double`.
  static absl::StatusOr<PortalLight> create(const Params& params, const Vec3& origin_m = {});
  /// Checks for the same errors without making the light's table.
  static absl::Status check(const Params& params, const Vec3& origin_m = {});

  /// A direction through the portal, distance infinite: surfaces behind the portal may still hide
  /// the sky.  Value and density belong to the rounded direction.
  ///
  /// Reasons without light:
  /// - kBehind: on the portal's other side, and in its plane beside it.
  /// - kDegenerate: on the portal.
  /// - kBlack: map, radiance or the sampled part of the map is black, or below any normal `double`.
  /// - kOutOfRange: the density is not a positive normal `double`, or the portal looks narrower
  /// than the rounding of a direction.
  LightSample sample_li(const Receiver& receiver, Vec2 u) const override;
  /// 0 outside of the portal's edges.
  SolidAnglePdf pdf_li(const Receiver& receiver, const Vec3& wi) const override;
  /// Irradiance without occlusion on the side that `receiver` faces [lx].  Nothing with a map, or
  /// if the receiver has no normal or is not finite.
  std::optional<Rgb> irradiance(const Receiver& receiver) const override;
  /// Upper bounds of the illuminance on the side that `receiver` faces: the integral of the
  /// radiance over all directions that can pass through the portal.
  MostIrradiance most_irradiance(const Receiver& receiver) const override;
  /// Radiance [cd/m2] that a ray from `origin` towards the unit vector `w` meets.  0 if the ray
  /// does not leave through the portal.
  Rgb le_escaped(const Vec3& origin, const Vec3& w) const override;
  /// The same for a ray that enters towards `w` and starts in the portal.
  Rgb le_leaving(const Vec3&, const Vec3& w, double = 0) const override { return radiance(-w); }

  /// A ray that enters: a point of the portal by area, a direction by the whole table.  `normal` is
  /// that of the portal, towards the inside.  The scene's sphere is not used.
  EmissionSample sample_le(Vec2 u_position, Vec2 u_direction,
                           const SceneSphere& scene) const override;
  /// `slack_m`: how far rounding may have moved `position` off the portal's plane, in addition to
  /// the rounding to `double`.
  EmissionPdf pdf_le(const Vec3& position, const Vec3& direction, const SceneSphere& scene,
                     double slack_m = 0) const override;

  /// Flux through the portal: its area times the illuminance of the sky on it.  Exact without a map
  /// and for a rectified map; else by quadrature with a bound on the error.
  Power power(const SceneSphere& scene) const override;
  /// The area times the integral of the radiance over the directions above it, without the cosine,
  /// as in pbrt-v4.
  Power power_approximate(const SceneSphere& scene) const override;

  /// The rectangle that is used, relative to the scene's origin.
  std::array<Vec3, 4> corners_m() const {
    const Vec3 x = x_ * width_, y = y_ * height_;
    return {corner_, corner_ + x, corner_ + x + y, corner_ + y};
  }
  /// Unit, out through the portal.
  const Vec3& to_sky() const { return z_; }
  double portal_area_m2() const { return width_ * height_; }
  /// The portal's area.
  std::optional<double> cross_section_m2(const SceneSphere& scene) const override;
  static LightPlace place(const Params& params);
  const Params& params() const { return params_; }
  /// The table that it samples and the picture that it resampled.
  LightBytes own_bytes() const override;
  SharedData shared_data() const override {
    return {.image = params_.map ? &params_.map->image() : nullptr};
  }
  std::optional<LightParams> made_from() const override;

 private:
  using Window = WindowedDistribution::Window;
  struct Rectangle {
    Vec3 corner;  ///< about the scene's origin [m]
    Vec3 x, y;    ///< unit
    double width, height;
  };
  static absl::StatusOr<Rectangle> rectangle(const Params& params, const Vec3& origin_m);
  PortalLight(const Params& params, const Rectangle& r);
  Vec3 local(const Vec3& v) const { return {dot(x_, v), dot(y_, v), dot(z_, v)}; }
  /// The window that `position` sees, or the reason why there is none.
  NoLight window(const Vec3& position, Window& window) const;
  /// The map towards `l` in the portal's axes; 1 without a map.
  Rgb sky(const Vec3& l) const;
  /// The irradiance of a sky of this radiance through the portal, or nothing.
  std::optional<Rgb> uniform_irradiance(const Rgb& radiance_cd_m2, const Receiver& receiver) const;
  /// Radiance from the unit vector `w`; 0 where it is not a positive normal `double`.
  Rgb radiance(const Vec3& w) const;
  /// Density with respect to solid angle at the unit vector `w` [1/sr]; 0 outside of the window.
  double density(const Window& window, const Vec3& w) const;
  /// A direction of the window in `wi`, with value and density; or the reason why there is none.
  NoLight sample(const Window& window, Vec2 u, Vec3& wi, Rgb& value, SolidAnglePdf& pdf) const;

  Params params_;
  MapAxes map_axes_;
  Vec3 corner_;               ///< about the scene's origin [m]
  Vec3 x_, y_, z_;            ///< the portal's axes, unit; z to where light comes from
  double width_, height_;     ///< along x_ and y_ [m]
  MapIlluminance on_portal_;  ///< [lx]
  std::shared_ptr<const RectifiedMap> rectified_;  ///< null: the map itself, or none
  std::shared_ptr<const WindowedDistribution> table_;
};

}  // namespace lucerna

// The cylinder without caps, whole or swept in part.  Rays can hit it under any affine map.  It can
// emit only under maps that preserve shares of area.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/maths/transform.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/quadric.h"

namespace lucerna {

/// Object space: about the z axis.  [Pharr23, 6.3]
struct CylinderParams {
  double radius_m = 1;  ///< > 0
  double z_min_m = -1;
  double z_max_m = 1;                      ///< > z_min_m
  double phi_max_rad = 6.283185307179586;  ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;        ///< normals point to the axis
  Transform world_from_object = {};
};

/// Normals are geometric.  They point away from the axis, also under mirrors, unless
/// `reverse_orientation` is set.  Immutable, so safe to share between threads.  Calls allocate only
/// for error messages.
class Cylinder final : public Quadric<Cylinder, CylinderParams> {
 public:
  static constexpr std::string_view kName = "cylinder";

  /// Errors: a field out of its domain; bounds that `double` cannot hold.
  static absl::StatusOr<Cylinder> create(const CylinderParams& params, const Vec3& origin_m = {});

  /// OK where this shape can carry a light: equal factors across the axis, any factor along it, no
  /// shear.  Else InvalidArgument with the factors.
  absl::Status emissive_error() const override;

  /// Uniform by area.  [Pharr23, 6.3.3]
  ShapeSample sample(const Receiver& receiver, Vec2 u) const override;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const override;

  /// Whether `p` lies on it, to within the rounding of doubles.
  bool touches(const Vec3& p, std::uint32_t primitive = 0) const override;

  bool has_closed_form() const override { return false; }
  bool has_fast_closed_form() const override { return false; }
  std::optional<double> projected_solid_angle_sr(const Vec3&, const Vec3&, bool) const override {
    return std::nullopt;
  }
  bool hides_itself() const override { return false; }
  /// All directions for a whole cylinder; for a part a cone around its middle.
  NormalCone normals() const override;

  /// The mapping of pictures: u is the share of the sweep, v runs from the lower end (0) to the
  /// upper end (1).  [Pharr23, 6.3.2]
  Vec2 uv(const SurfacePoint& point) const override;
  BandArea area_of(const Band& band) const override;
  SurfacePoint at_shares(Vec2 shares) const override;

  /// World bounds about the origin, {lower, upper}. A part has the bounds of the whole cylinder.
  std::pair<Vec3, Vec3> bounds() const override;
  /// None: the cylinder is not flat.
  std::optional<double> height_over(const SurfacePoint&, const Vec3&) const override {
    return std::nullopt;
  }

  /// The whole cylinder, with its ends.
  RoundEnclosure enclosure() const {
    const Transform& t = this->world_from_object();
    const auto& p = this->params();
    return {t.point({0, 0, (p.z_min_m + p.z_max_m) / 2}), t.vector({p.radius_m, 0, 0}),
            t.vector({0, p.radius_m, 0}), t.vector({0, 0, (p.z_max_m - p.z_min_m) / 2}), true};
  }

 private:
  Cylinder(const CylinderParams& params, const Vec3& origin_m);
  /// The ends are open.  Rays along the axis do not hit.
  int roots(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
            QuadricRoots& out) const;
  bool is_cut_away(const Vec3& p) const;
  std::optional<Vec3> nearest(const Vec3& q) const;
  Vec3 normal_at(const Vec3& p) const { return this->oriented({p.x, p.y, 0}); }

  using Base = Quadric<Cylinder, CylinderParams>;
  friend Base;
  using Base::area_m2_, Base::object_from_world_, Base::params_, Base::world_from_object_;
  using Base::on_ring, Base::pdf_by_area, Base::surface_point;
};

}  // namespace lucerna

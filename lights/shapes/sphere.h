// The sphere, whole or cut by two planes and a sweep.  Rays can hit it under any affine map.  It
// can emit only under maps of equal scale.
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

/// Object space: centre at the origin.  [Pharr23, 6.2]
struct SphereParams {
  double radius_m = 1;                                        ///< > 0
  double z_min_m = -std::numeric_limits<double>::infinity();  ///< cut below; clamped to the radius
  double z_max_m = std::numeric_limits<double>::infinity();   ///< cut above; clamped to the radius
  double phi_max_rad = 6.283185307179586;                     ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;                           ///< normals point inwards
  Transform world_from_object = {};
};

/// Normals are geometric.  They point outwards, also under mirrors, unless `reverse_orientation` is
/// set.  Immutable, so safe to share between threads.  Calls allocate only for error messages.
class Sphere final : public Quadric<Sphere, SphereParams> {
 public:
  static constexpr std::string_view kName = "sphere";

  /// Errors: a field out of its domain; nothing left of the sphere; bounds that `double` cannot
  /// hold.
  static absl::StatusOr<Sphere> create(const SphereParams& params, const Vec3& origin_m = {});

  /// OK where this shape can carry a light.  Else InvalidArgument with the unequal factors.
  absl::Status emissive_error() const override;

  /// A point seen from `receiver`, chosen in the way that it requests.  With kSolidAngle, a whole
  /// sphere is sampled uniformly in its cone from outside, and uniformly over all directions from
  /// inside.  Cut spheres, and receivers within a thousandth of the radius below the surface, use
  /// area sampling.  [Pharr23, 6.2.4]
  ShapeSample sample(const Receiver& receiver, Vec2 u) const override;
  /// The density of `sample` at a point of the surface.  For a whole sphere seen from outside, 0 on
  /// the far side, which is never sampled.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const override;

  /// Whether `p` lies on it, to within the rounding of doubles.
  bool touches(const Vec3& p, std::uint32_t primitive = 0) const override;

  bool has_closed_form() const override { return true; }
  bool has_fast_closed_form() const override { return true; }
  /// The projected solid angle [sr] of the sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`. From outside, the near side counts; from inside, all.  Nothing for
  /// cut spheres, and for positions on the surface to within the rounding of doubles.
  std::optional<double> projected_solid_angle_sr(const Vec3& position, const Vec3& normal,
                                                 bool two_sided) const override;
  /// No part of its near side occludes another.
  bool hides_itself() const override { return false; }

  /// All directions for a whole sphere; for a part a cone that contains its normals.
  NormalCone normals() const override;

  /// The mapping of pictures: u is the share of the sweep, v runs from the lower end (0) to the
  /// upper end (1).  [Pharr23, 6.2.2]
  Vec2 uv(const SurfacePoint& point) const override;
  BandArea area_of(const Band& band) const override;
  SurfacePoint at_shares(Vec2 shares) const override;

  /// World bounds about the origin, {lower, upper}.
  std::pair<Vec3, Vec3> bounds() const override;
  /// None: the sphere is not flat.
  std::optional<double> height_over(const SurfacePoint&, const Vec3&) const override {
    return std::nullopt;
  }

  /// The ellipsoid that it is a part of.
  RoundEnclosure enclosure() const {
    const Transform& t = this->world_from_object();
    const double r = this->params().radius_m;
    return {t.point({0, 0, 0}), t.vector({r, 0, 0}), t.vector({0, r, 0}), t.vector({0, 0, r}),
            false};
  }

 private:
  Sphere(const SphereParams& params, const Vec3& origin_m);
  int roots(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
            QuadricRoots& out) const;
  bool is_cut_away(const Vec3& p) const;
  std::optional<Vec3> nearest(const Vec3& q) const;
  Vec3 normal_at(const Vec3& p) const { return this->oriented(p); }
  enum class Way { kArea, kCone, kInside };
  /// The single test of inside and outside, for sampling and density.
  Way way_at(double distance, const Receiver& receiver) const;

  using Base = Quadric<Sphere, SphereParams>;
  friend Base;
  using Base::area_m2_, Base::object_from_world_, Base::params_, Base::world_from_object_;
  using Base::on_ring, Base::pdf_by_area, Base::surface_point;

  double z_min_m_, z_max_m_;  // within the radius
  bool is_cut_in_z_, is_cut_in_phi_, is_whole_;
  Vec3 center_m_;
  double world_radius_m_ = 0;  // 0 if the scale is unequal
};

}  // namespace lucerna

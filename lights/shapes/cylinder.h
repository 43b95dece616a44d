// The cylinder without caps, whole or swept in part, under any affine map for intersection and
// under maps that keep its share of area uniform for emission.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "lights/maths/normal_cone.h"
#include "lights/maths/transform.h"
#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"

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

/// Normals are geometric and point away from the axis, through mirrors too, unless
/// `reverse_orientation`.  Immutable, so safe to share between threads; no call allocates but for
/// error messages.
template <typename Real>
class Cylinder {
 public:
  /// Errors: a field out of its domain, or bounds that `Real` does not hold.
  static absl::StatusOr<Cylinder> create(const CylinderParams& params,
                                         const Vec3<double>& origin_m = {});

  /// [m2].  Requires a map that keeps shares of area (`emissive_error` is OK); 0 otherwise.
  double area() const { return area_m2_; }
  /// OK where this shape can carry a light: equal factors across the axis, any along it, no shear.
  /// Else InvalidArgument that names the factors.
  absl::Status emissive_error() const;

  /// Uniform by area.  [Pharr23, 6.3.3]
  ShapeSample<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf<Real> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// First hit with t in (t_min, t_max), `direction` of any length.  The ends are open and what is
  /// not swept is passed through.  The point is put back on the surface.  Rays along the axis do
  /// not hit.
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max) const;
  /// All hits with t in (t_min, t_max).
  ShapeHits<Real> hits(const Vec3<Real>& origin, const Vec3<Real>& direction, Real t_min,
                       Real t_max) const;

  /// Calls `f(surface_point)` for every point of the surface along the unit vector `wi`.
  template <typename F>
  void for_each_hit(const Vec3<Real>& receiver, const Vec3<Real>& wi, F&& f) const {
    const auto found = hits(receiver, wi, 0, std::numeric_limits<Real>::infinity());
    for (int i = 0; i < found.count; ++i) f(found.hit[i].point);
  }

  /// Whether `p` lies on it, as far as doubles tell.
  bool touches(const Vec3<Real>& p, std::uint32_t primitive = 0) const;

  /// Density of points by area alone; 1 / area.
  AreaPdf<double> pdf_area(const SurfacePoint<Real>&) const { return {1 / area_m2_}; }
  /// The point of the surface at `position`, where there is one to within rounding and `slack_m`.
  std::optional<SurfacePoint<Real>> locate(const Vec3<Real>& position, double slack_m = 0) const;
  /// All directions of a whole cylinder; of a part a cone about its middle.
  NormalCone<Real> normals() const;

  /// How pictures lie on it: u the share of the sweep, v from the lower end (0) to the upper end
  /// (1). [Pharr23, 6.3.2]
  Vec2<double> uv(const Vec3<Real>& position) const;
  BandArea area_of(const Band& band) const;
  /// The point at a share of the sweep and a share of the area below it, both in [0, 1].
  SurfacePoint<Real> at_shares(Vec2<double> shares) const;

  /// World bounds about the origin, {lower, upper}; those of the whole cylinder for a part.
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  std::size_t bytes() const { return sizeof(*this); }
  const CylinderParams& params() const { return params_; }
  /// About the origin that it was created with, not the world's.
  const Transform& world_from_object() const { return world_from_object_; }

 private:
  Cylinder(const CylinderParams& params, const Vec3<double>& origin_m);
  bool is_cut_away(const Vec3<double>& p) const;
  SurfacePoint<Real> surface_point(const Vec3<double>& p) const;

  CylinderParams params_;
  Transform world_from_object_, object_from_world_;  // about the scene's origin
  double area_m2_ = 0;                               // 0 where the map shares area out unevenly
};

extern template class Cylinder<float>;
extern template class Cylinder<double>;

}  // namespace lucerna

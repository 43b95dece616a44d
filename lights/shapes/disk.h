// The disk, whole or an annulus or a sector, under any affine map (an ellipse's share of area is
// still uniform).
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

/// Object space: in the plane z = height, normal +z.  [Pharr23, 6.4]
struct DiskParams {
  double height_m = 0;
  double radius_m = 1;                     ///< > 0
  double inner_radius_m = 0;               ///< [0, radius)
  double phi_max_rad = 6.283185307179586;  ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;        ///< the normal points to -z
  Transform world_from_object = {};
};

/// The normal stays on the side of object space's +z, through mirrors too, unless
/// `reverse_orientation`.  Immutable, so safe to share between threads; no call allocates but for
/// error messages.
template <typename Real>
class Disk {
 public:
  /// Errors: a field out of its domain, or bounds that `Real` does not hold.
  static absl::StatusOr<Disk> create(const DiskParams& params, const Vec3<double>& origin_m = {});

  /// [m2]
  double area() const { return area_m2_; }
  /// Always OK.
  absl::Status emissive_error() const { return absl::OkStatus(); }

  /// In the way that `receiver` asks for.  kSolidAngle: a whole disk under a map of equal scale,
  /// seen from where lights/sampling/spherical_ellipse.h has a density; all else uniformly by area.
  /// [Pharr23, 6.4.3; Guillen17]
  ShapeSample<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf<Real> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// The hit, if its t is in (t_min, t_max); `direction` of any length.  The point is put back into
  /// the plane.  A ray within the plane does not hit.
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max) const;
  /// Calls `f(surface_point)` for every point of the surface along the unit vector `wi`.
  template <typename F>
  void for_each_hit(const Vec3<Real>& receiver, const Vec3<Real>& wi, F&& f) const {
    if (const auto hit = intersect(receiver, wi, 0, std::numeric_limits<Real>::infinity()))
      f(hit->point);
  }

  /// How far `p` is above the plane, on the side of the normal [m]; as Triangle has it.
  double height_of(const Vec3<Real>& p) const;
  std::optional<double> height_over(const SurfacePoint<Real>&, const Vec3<Real>& p) const {
    return height_of(p);
  }
  /// Whether `p`, 0 above the plane, is within the disk or on its edges to 1e-14.
  bool touches(const Vec3<Real>& p, std::uint32_t primitive = 0) const;

  /// The projected solid angle [sr] of the sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`; nothing for what is no whole circle.
  std::optional<double> projected_solid_angle_sr(const Vec3<Real>& position,
                                                 const Vec3<double>& normal, bool two_sided) const;
  bool hides_itself() const { return false; }

  /// Density of points by area alone; 1 / area.
  AreaPdf<double> pdf_area(const SurfacePoint<Real>&) const { return {1 / area_m2_}; }
  /// The point of the surface at `position`, where there is one to within rounding and `slack_m`.
  std::optional<SurfacePoint<Real>> locate(const Vec3<Real>& position, double slack_m = 0) const;
  /// The one normal.
  NormalCone<Real> normals() const;

  /// How pictures lie on it: u the share of the sweep, v from the rim (0) to the inner edge (1).
  /// [Pharr23, 6.4.2]
  Vec2<double> uv(const Vec3<Real>& position) const;
  BandArea area_of(const Band& band) const;
  /// The point at a share of the sweep and a share of the area below it, both in [0, 1].
  SurfacePoint<Real> at_shares(Vec2<double> shares) const;

  /// World bounds about the origin, {lower, upper}; those of the whole disk for a sector.
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  std::size_t bytes() const { return sizeof(*this); }
  const DiskParams& params() const { return params_; }
  /// About the origin that it was created with, not the world's.
  const Transform& world_from_object() const { return world_from_object_; }

 private:
  Disk(const DiskParams& params, const Vec3<double>& origin_m);
  struct Seen;
  Seen seen_from(const Receiver<Real>& receiver) const;
  SolidAnglePdf<Real> pdf(const Seen& seen, const Receiver<Real>& receiver,
                          const SurfacePoint<Real>& point) const;

  DiskParams params_;
  Transform world_from_object_, object_from_world_;  // about the scene's origin
  Vec3<Real> normal_;
  double area_m2_;
  bool is_circle_;  // whole, and a circle in the world
};

extern template class Disk<float>;
extern template class Disk<double>;

}  // namespace lucerna

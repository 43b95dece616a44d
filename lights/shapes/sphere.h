// The sphere, whole or cut by two planes and a sweep, under any affine map for intersection and
// under maps of equal scale for emission.
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

/// Object space: centre at the origin.  [Pharr23, 6.2]
struct SphereParams {
  double radius_m = 1;                                        ///< > 0
  double z_min_m = -std::numeric_limits<double>::infinity();  ///< cut below; clamped to the radius
  double z_max_m = std::numeric_limits<double>::infinity();   ///< cut above; clamped to the radius
  double phi_max_rad = 6.283185307179586;                     ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;                           ///< normals point inwards
  Transform world_from_object = {};
};

/// Normals are geometric and point outwards, through mirrors too, unless `reverse_orientation`.
/// Immutable, so safe to share between threads; no call allocates but for error messages.
template <typename Real>
class Sphere {
 public:
  /// Errors: a field out of its domain, nothing left of the sphere, or bounds that `Real` does not
  /// hold.
  static absl::StatusOr<Sphere> create(const SphereParams& params,
                                       const Vec3<double>& origin_m = {});

  /// [m2].  Requires a map of equal scale (`emissive_error` is OK); 0 otherwise.
  double area() const { return area_m2_; }
  /// OK where this shape can carry a light; else InvalidArgument that names the unequal factors.
  absl::Status emissive_error() const;

  /// A point seen from `receiver`, in the way that it asks for.  kSolidAngle: a whole sphere by the
  /// cone that it subtends from outside, by all directions alike from inside; cut spheres and
  /// receivers within a thousandth of the radius beneath the surface by area.  [Pharr23, 6.2.4]
  ShapeSample<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// The density of `sample` at a point of the surface; 0 on the far side of a whole sphere seen
  /// from outside, which the cone never samples.
  SolidAnglePdf<Real> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// First hit with t in (t_min, t_max), `direction` of any length.  The cut-away part is passed
  /// through.  The point is put back on the surface.
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

  /// The projected solid angle [sr] of the sides that emit towards `position`, above the horizon of
  /// the unit vector `normal`: of the near side from outside, of all from inside.  Nothing for cut
  /// spheres, nor on the surface as far as doubles tell.
  std::optional<double> projected_solid_angle_sr(const Vec3<Real>& position,
                                                 const Vec3<double>& normal, bool two_sided) const;
  /// Its near side is no shadow on its near side.
  bool hides_itself() const { return false; }

  /// Density of points by area alone; 1 / area.
  AreaPdf<double> pdf_area(const SurfacePoint<Real>&) const { return {1 / area_m2_}; }
  /// The point of the surface at `position`, where there is one to within rounding and `slack_m`.
  std::optional<SurfacePoint<Real>> locate(const Vec3<Real>& position, double slack_m = 0) const;
  /// All directions of a whole sphere; of a part a cone that holds it.
  NormalCone<Real> normals() const;

  /// How pictures lie on it: u the share of the sweep, v from the lower end (0) to the upper end
  /// (1). [Pharr23, 6.2.2]
  Vec2<double> uv(const Vec3<Real>& position) const;
  BandArea area_of(const Band& band) const;
  /// The point at a share of the sweep and a share of the area below it, both in [0, 1].
  SurfacePoint<Real> at_shares(Vec2<double> shares) const;

  /// World bounds about the origin, {lower, upper}.
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  std::size_t bytes() const { return sizeof(*this); }
  const SphereParams& params() const { return params_; }
  /// About the origin that it was created with, not the world's.
  const Transform& world_from_object() const { return world_from_object_; }

 private:
  /// Where a ray meets the whole sphere, in object space.
  struct Root {
    double t;
    Vec3<double> p;
  };

  Sphere(const SphereParams& params, const Vec3<double>& origin_m);
  int roots(const Vec3<Real>& origin, const Vec3<Real>& direction, Root (&out)[2]) const;
  bool is_cut_away(const Vec3<double>& p) const;
  SurfacePoint<Real> surface_point(const Vec3<double>& p) const;
  enum class Way { kArea, kCone, kInside };
  /// The one test of inside and outside, for sampling and density.
  Way way_at(double distance, const Receiver<Real>& receiver) const;

  SphereParams params_;
  Transform world_from_object_, object_from_world_;  // about the scene's origin
  double z_min_m_, z_max_m_;                         // within the radius
  bool is_cut_in_z_, is_cut_in_phi_, is_whole_;
  Vec3<double> center_m_;
  double world_radius_m_ = 0;  // 0 where the scale is unequal
  double area_m2_ = 0;
};

extern template class Sphere<float>;
extern template class Sphere<double>;

}  // namespace lucerna

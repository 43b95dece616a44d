// The sphere, whole or cut by two planes and a sweep, under any affine map for intersection and
// under maps of equal scale for emission.
#pragma once

#include <absl/status/statusor.h>

#include <limits>
#include <optional>

#include "lights/light_sample.h"
#include "lights/transform.h"

namespace lucerna {

/// What a shape's sampling answers: a point, and the density of its direction from the receiver.
template <std::floating_point Real>
struct ShapeSample {
  SurfacePoint<Real> point;
  SolidAnglePdf<Real> pdf;  ///< not positive or not finite: no direction exists for this point
};

/// Where a ray meets an analytic shape.
template <std::floating_point Real>
struct ShapeHit {
  Real t{};                 ///< along the ray, in units of its direction
  SurfacePoint<Real> point;
};

/// Object space: centre at the origin.  [Pharr23, 6.2]
struct SphereParams {
  double radius_m = 1;                     ///< > 0
  double z_min_m = -std::numeric_limits<double>::infinity();  ///< cut below; clamped to the radius
  double z_max_m = std::numeric_limits<double>::infinity();   ///< cut above; clamped to the radius
  double phi_max_rad = 6.283185307179586;  ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;        ///< normals point inwards
  Transform world_from_object;
};

template <typename Real>
class Sphere {
 public:
  /// Errors: a field out of its domain, or nothing left of the sphere.
  static absl::StatusOr<Sphere> create(const SphereParams& params,
                                       const Vec3<double>& origin_m = {});

  /// [m2].  Requires a map of equal scale (`emissive_error` is OK).
  double area() const;
  /// OK where this shape can carry a light; else what keeps it from doing so (unequal scale).
  absl::Status emissive_error() const;

  /// A point seen from `receiver`: by the cone that the whole sphere subtends where the receiver is
  /// outside of it, uniformly by area inside and for cut spheres.  [Pharr23, 6.2.4]
  ShapeSample<Real> sample(const Vec3<Real>& receiver, Vec2<Real> u) const;
  /// The density of `sample` at a point of the surface.
  SolidAnglePdf<Real> pdf(const Vec3<Real>& receiver, const SurfacePoint<Real>& point) const;

  /// First hit with t in (t_min, t_max), `direction` of any length.
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max) const;

  /// Calls `f(surface_point)` for every point of the surface along the unit vector `wi`.
  template <typename F>
  void for_each_hit(const Vec3<Real>& receiver, const Vec3<Real>& wi, F&& f) const {
    Real t = 0;
    for (int hits = 0; hits < 2; ++hits) {
      const auto hit = intersect(receiver, wi, t, std::numeric_limits<Real>::infinity());
      if (!hit) return;
      f(hit->point);
      t = hit->t;
    }
  }

  /// World bounds about the origin, {lower, upper}.
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  std::size_t bytes() const { return sizeof(*this); }
  const SphereParams& params() const { return params_; }

 private:
  explicit Sphere(const SphereParams& params, const Vec3<double>& origin_m);
  SphereParams params_;
  // The implementer's choice of what else is kept.
};

}  // namespace lucerna

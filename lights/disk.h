// The disk, whole or an annulus or a sector, under any affine map (an ellipse's share of area is
// still uniform).
#pragma once

#include <absl/status/statusor.h>

#include "lights/sphere.h"

namespace lucerna {

/// Object space: in the plane z = height, normal +z.  [Pharr23, 6.4]
struct DiskParams {
  double height_m = 0;
  double radius_m = 1;                     ///< > 0
  double inner_radius_m = 0;               ///< [0, radius)
  double phi_max_rad = 6.283185307179586;  ///< swept about +z from +x; (0, 2 pi]
  bool reverse_orientation = false;        ///< the normal points to -z
  Transform world_from_object;
};

template <typename Real>
class Disk {
 public:
  static absl::StatusOr<Disk> create(const DiskParams& params, const Vec3<double>& origin_m = {});
  double area() const;
  absl::Status emissive_error() const;  ///< always OK
  /// Uniform by area.  [Pharr23, 6.4.3]
  ShapeSample<Real> sample(const Vec3<Real>& receiver, Vec2<Real> u) const;
  SolidAnglePdf<Real> pdf(const Vec3<Real>& receiver, const SurfacePoint<Real>& point) const;
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max) const;
  template <typename F>
  void for_each_hit(const Vec3<Real>& receiver, const Vec3<Real>& wi, F&& f) const {
    if (const auto hit = intersect(receiver, wi, 0, std::numeric_limits<Real>::infinity()))
      f(hit->point);
  }
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
  std::size_t bytes() const { return sizeof(*this); }
  const DiskParams& params() const { return params_; }

 private:
  explicit Disk(const DiskParams& params, const Vec3<double>& origin_m);
  DiskParams params_;
};

}  // namespace lucerna

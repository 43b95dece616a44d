// The bilinear patch p(u, v) through four corners, flat or not.
#pragma once

#include <optional>
#include <utility>

#include "lights/light_sample.h"
#include "lights/sphere.h"

namespace lucerna {

/// Corners at (u, v) = (0,0), (1,0), (0,1), (1,1), as .pbrt files order them.  Normal:
/// cross(dp/du, dp/dv).  [Pharr23, 6.6]
template <typename Real>
struct BilinearPatch {
  Vec3<Real> p00, p10, p01, p11;

  /// Exact for flat patches; otherwise by quadrature to 1e-6.
  Real area() const;
  Vec3<Real> at(Vec2<Real> uv) const;
  /// Unit normal at (u, v); zero where the patch is degenerate.
  Vec3<Real> normal(Vec2<Real> uv) const;
  SurfacePoint<Real> sample_area(Vec2<Real> u) const;
  AreaPdf<Real> pdf_area(const Vec3<Real>& position) const;
  /// Nearest hit in (t_min, t_max); `uv` of the hit, if asked for, goes to `*uv_hit`.  [Reshetov19]
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max, Vec2<Real>* uv_hit = nullptr) const;
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
};

}  // namespace lucerna

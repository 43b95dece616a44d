// The bilinear patch p(u, v) through four corners, flat or not.
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"

namespace lucerna {

/// [m2], with a bound on its error; 0 where the form is exact, roundings left out.
struct BilinearPatchArea {
  double m2 = 0, error_m2 = 0;
};

/// Corners at (u, v) = (0,0), (1,0), (0,1), (1,1), as .pbrt files order them.  Normal:
/// cross(dp/du, dp/dv).  [Pharr23, 6.6]
template <typename Real>
struct BilinearPatch {
  Vec3<Real> p00, p10, p01, p11;

  /// Exact for flat convex patches, where flat is to 1e-6 rad as rounded corners are, and 1e-12 of
  /// the area; otherwise by quadrature to 1e-8, of folded patches to 1e-4.
  BilinearPatchArea measure() const;
  /// The same without its error [m2].
  double area() const { return measure().m2; }
  Vec3<Real> at(Vec2<Real> uv) const;
  /// Unit normal at (u, v); zero where the patch is degenerate.
  Vec3<Real> normal(Vec2<Real> uv) const;
  /// By the share of area |dp/du x dp/dv|, bilinear between its values at the corners: uniform on
  /// flat convex patches.  `u` in [0, 1]^2.  [Pharr23, 6.6.2]
  SurfacePoint<Real> sample_area(Vec2<Real> u) const;
  /// The same with the density as `receiver` sees it.
  ChosenPoint<Real> sample_area(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// Density of sample_area at a point of the patch, all (u, v) that lead there taken together.
  AreaPdf<double> pdf_area(const Vec3<Real>& position) const;
  /// |dp/du x dp/dv| [m2]
  double area_element(Vec2<double> uv) const;
  /// No more than any area_element [m2]: the least that their common side shows of the corners'
  /// area vectors, between which those within are linear; 0 where the patch folds over.
  double least_area_element() const;
  /// Whether each point is that of one (u, v) only: its normals lie within a hemisphere.
  bool is_unfolded() const;
  /// Flat, with corners of 90 degrees, to 1e-6.
  bool is_rectangle() const;
  /// Convex, and in one plane but for the rounding of its corners as `Real` has them: one height
  /// is that over all of it.
  bool is_flat() const;
  /// Of a flat patch, as Triangle has it; 0 at the fourth corner too.
  double height_of(const Vec3<Real>& p) const;
  /// Of a flat patch, as Triangle has it.
  bool touches(const Vec3<Real>& p) const;
  /// Of a rectangle: the way that `receiver` asks for; sample_area where there is no density by
  /// solid angle, and without the cosine's warp where lights/sampling/spherical_fan.h has one.  `u`
  /// in [0, 1]^2.  [Urena13]
  ChosenPoint<Real> sample(const Receiver<Real>& receiver, Vec2<Real> u) const;
  /// Density of `sample` at a point of the rectangle.
  SolidAnglePdf<double> pdf(const Receiver<Real>& receiver, const SurfacePoint<Real>& point) const;
  /// Nearest hit in (t_min, t_max); `uv` of the hit, if asked for, goes to `*uv_hit`.  [Reshetov19]
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max,
                                          Vec2<Real>* uv_hit = nullptr) const;
  /// Both hits, where a ray meets the patch twice.
  ShapeHits<Real> hits(const Vec3<Real>& origin, const Vec3<Real>& direction, Real t_min,
                       Real t_max, std::array<Vec2<Real>, 2>* uv_hits = nullptr) const;
  /// The (u, v) whose point is nearest to `position`, a point of the patch to within rounding.
  Vec2<Real> locate(const Vec3<Real>& position) const;
  /// {lower, upper}
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
};

extern template struct BilinearPatch<float>;
extern template struct BilinearPatch<double>;

}  // namespace lucerna

// The bilinear patch p(u, v) through four corners, flat or not.
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"

namespace lucerna {

/// An area [m2] with a bound on its error, without roundings.  The bound is 0 where the form is
/// exact.
struct BilinearPatchArea {
  double m2 = 0, error_m2 = 0;
};

/// Corners at (u, v) = (0,0), (1,0), (0,1), (1,1), in the order of .pbrt files.  Normal:
/// cross(dp/du, dp/dv).  [Pharr23, 6.6]
struct BilinearPatch {
  Vec3 p00, p10, p01, p11;

  /// The area.  Exact to 1e-12 for flat convex patches.  Flat means to 1e-6 rad, which allows for
  /// rounded corners.  Other patches use quadrature to 1e-8, folded patches to 1e-4.
  BilinearPatchArea measure() const;
  /// The same without its error [m2].
  double area() const { return measure().m2; }
  Vec3 at(Vec2 uv) const;
  /// Unit normal at (u, v); zero where the patch is degenerate.
  Vec3 normal(Vec2 uv) const;
  /// A point with a density in (u, v) proportional to |dp/du x dp/dv| at the corners, bilinear
  /// between them.  Uniform on flat convex patches.  `u` in [0, 1]^2.  [Pharr23, 6.6.2]
  SurfacePoint sample_area(Vec2 u) const;
  /// The same with the density at `receiver`.
  ShapeSample sample_area(const Receiver& receiver, Vec2 u) const;
  /// Density of sample_area at a point of the patch, summed over all (u, v) of that point.
  AreaPdf pdf_area(const Vec3& position) const;
  /// |dp/du x dp/dv| [m2]
  double area_element(Vec2 uv) const;
  /// A lower bound on area_element [m2].  Area vectors are linear between those at the corners, and
  /// the bound is their smallest component along a common direction.  0 where the patch folds over.
  double least_area_element() const;
  /// Whether each point belongs to only one (u, v): the normals lie within a hemisphere.
  bool is_unfolded() const;
  /// Flat, with corners of 90 degrees, to 1e-6.
  bool is_rectangle() const;
  /// Whether the patch is convex and in one plane, up to the rounding of its corners to `double`.
  /// All of it then has one height.
  bool is_flat() const;
  /// Height of `p` as in Triangle, for a flat patch [m]; 0 at the fourth corner too.
  double height_of(const Vec3& p) const;
  /// As in Triangle, for a flat patch.
  bool touches(const Vec3& p) const;
  /// For a rectangle: a point chosen in the way that `receiver` requests.  Uses sample_area if
  /// there is no density by solid angle.  Without the cosine's warp if
  /// lights/sampling/spherical_fan.h applies.  `u` in [0, 1]^2.  [Urena13]
  ShapeSample sample(const Receiver& receiver, Vec2 u) const;
  /// Density of `sample` at a point of the rectangle.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const;
  /// Nearest hit in (t_min, t_max). Its (u, v) goes to `*uv_hit` if that is not null. [Reshetov19]
  std::optional<ShapeHit> intersect(const Vec3& origin, const Vec3& direction, double t_min,
                                    double t_max, Vec2* uv_hit = nullptr) const;
  /// Both hits, where a ray meets the patch twice.
  ShapeHits hits(const Vec3& origin, const Vec3& direction, double t_min, double t_max,
                 std::array<Vec2, 2>* uv_hits = nullptr) const;
  /// The (u, v) whose point is nearest to `position`, a point of the patch to within rounding.
  Vec2 locate(const Vec3& position) const;
  /// {lower, upper}
  std::pair<Vec3, Vec3> bounds() const;
};

}  // namespace lucerna

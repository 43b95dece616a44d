// The triangle: area sampling, density, intersection.
#pragma once

#include <optional>
#include <utility>

#include "lights/sampling/light_sample.h"
#include "lights/shapes/shape.h"

namespace lucerna {

/// Normal: cross(b - a, c - a).
struct Triangle {
  Vec3 a, b, c;

  /// The area [m2].  In double, for needles of 1 : 1e7 and for coordinates whose squares exceed the
  /// range of `double`.
  double area() const;
  /// Unit normal; zero for a triangle without area.
  Vec3 normal() const;
  /// How far `p` is above the plane, on the side of the normal [m]. Exact to 1e-11 and in its sign,
  /// even at 1e-20 of the triangle's size.  0 for a triangle without area.
  double height_of(const Vec3& p) const;
  /// Uniform by area, by any of the five maps of lights/sampling/sampling.h.  `u` in [0, 1]^2.
  SurfacePoint sample_area(Vec2 u, AreaSampling way = AreaSampling::kLowDistortion) const;
  /// Density of sample_area at a point of the triangle: 1 / area.
  AreaPdf pdf_area(const Vec3& position) const;
  /// A point chosen in the way that `receiver` requests.  Uses area sampling if there is no density
  /// by solid angle.  Without the cosine's warp if lights/sampling/low_triangle.h applies.  The
  /// density of the point has the same bits as `pdf`.  [Arvo95]
  ShapeSample sample(const Receiver& receiver, Vec2 u) const;
  /// Density of `sample` at a point of the triangle.
  SolidAnglePdf pdf(const Receiver& receiver, const SurfacePoint& point) const;
  /// The hit, if its t is in (t_min, t_max); `direction` of any length.  Edges and vertices belong
  /// to the triangle, and a ray through the common edge of two triangles hits at least one.
  /// [Woop13]
  std::optional<ShapeHit> intersect(const Vec3& origin, const Vec3& direction, double t_min,
                                    double t_max) const;
  /// The same as a list.
  ShapeHits hits(const Vec3& origin, const Vec3& direction, double t_min, double t_max) const;
  /// The coordinates of `position` along the edges from a to b and from a to c.  `position` is a
  /// point of the triangle up to rounding.  0 for needles too thin for doubles.
  Vec2 shares_at(const Vec3& position) const;
  /// The distance of `position` from the triangle [m]: from its plane, or within the plane from its
  /// edges.
  double distance_to(const Vec3& position) const;
  /// Whether `p`, in the plane (`height_of` is 0), is within the edges or on them to 1e-14.
  bool touches(const Vec3& p) const;
  /// {lower, upper}
  std::pair<Vec3, Vec3> bounds() const;
};

}  // namespace lucerna

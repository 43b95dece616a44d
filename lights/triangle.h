// The triangle: area sampling, density, intersection.
#pragma once

#include <optional>
#include <utility>

#include "lights/light_sample.h"
#include "lights/sphere.h"

namespace lucerna {

/// Normal: cross(b - a, c - a).
template <typename Real>
struct Triangle {
  Vec3<Real> a, b, c;

  Real area() const;
  /// Unit normal; zero for a triangle without area.
  Vec3<Real> normal() const;
  /// Uniform by area.
  SurfacePoint<Real> sample_area(Vec2<Real> u) const;
  /// Density of sample_area at a point of the triangle.
  AreaPdf<Real> pdf_area(const Vec3<Real>& position) const;
  std::optional<ShapeHit<Real>> intersect(const Vec3<Real>& origin, const Vec3<Real>& direction,
                                          Real t_min, Real t_max) const;
  std::pair<Vec3<Real>, Vec3<Real>> bounds() const;
};

}  // namespace lucerna

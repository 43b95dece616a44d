// Triangles whose planes Embree's floats do not resolve.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// A triangle that rays meet in double, with corners in double: one that is large compared with
/// other shapes, and not in a plane of the axes.
struct LargeTriangle {
  std::uint32_t triangle = 0;     ///< its number in GeometrySet::triangles
  std::array<Vec3, 3> corners{};  ///< [m]
};

/// A triangle is large if rays would find its plane with an error above this share of the smallest
/// shape's extent, and less than this number of triangles of its set are large already.
inline constexpr double kLargeShare = 1e-3;
inline constexpr std::size_t kMostLargeTriangles = 4096;

/// The largest error with which Embree finds the triangle's plane, along its normal [m].  0 in a
/// plane of the axes (error_bounds.h).
double ray_error_of(const std::array<Vec3, 3>& corners);

struct WideHit {
  double t = 0;
  Vec2 uv;  ///< barycentric coordinates of corners 1 and 2
};

/// The point of the triangle on the ray from `origin` [m], at t in (t_min, t_max).  Two triangles
/// with a common edge leave no gap there.
std::optional<WideHit> intersect(const LargeTriangle& triangle, const Vec3& origin,
                                 const Vec3& direction, double t_min, double t_max);

}  // namespace lucerna

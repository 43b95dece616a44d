// Warps from the unit square to the domains that lights sample, each with its density.  Every warp
// accepts the closed square: u = 0, 1 - 2^-24 and 1 give points of the domain.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <type_traits>

#include "lights/maths/density.h"
#include "lights/maths/vec.h"
#include "lights/sampling/area_sampling.h"

namespace lucerna {

/// A unit vector, uniform over the sphere.  The radius comes from u (1 - u).  1 - z^2 would cancel
/// at the poles.
template <std::floating_point T>
BasicVec3<T> sample_uniform_sphere(BasicVec2<T> u) {
  const T r = 2 * std::sqrt(u.x * (1 - u.x));
  const T phi = 2 * std::numbers::pi_v<T> * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - 2 * u.x};
}

inline SolidAnglePdf uniform_sphere_pdf() { return {std::numbers::inv_pi / 4}; }

/// A unit vector within an angle theta of +z, uniform in solid angle.  `one_minus_cos` is 1 -
/// cos(theta), in [0, 2].  Compute it as sin^2 / (1 + cos) or 2 sin^2(theta / 2), because the
/// difference cancels for narrow cones.
template <std::floating_point T>
BasicVec3<T> sample_uniform_cone(BasicVec2<T> u, T one_minus_cos) {
  const T h = u.x * one_minus_cos;
  const T r = std::sqrt(std::max(T(0), h * (2 - h)));
  const T phi = 2 * std::numbers::pi_v<T> * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - h};
}

/// The density within the cone; infinite if the cone has no extent.
inline SolidAnglePdf uniform_cone_pdf(double one_minus_cos) {
  return {std::numbers::inv_pi / (2 * one_minus_cos)};
}

/// `a` if `first`, else `b`.  Without a branch, for choices that no processor can predict.
template <std::floating_point T>
T select(bool first, T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  const Bits mask = first ? ~Bits{0} : Bits{0};
  return std::bit_cast<T>((std::bit_cast<Bits>(a) & mask) | (std::bit_cast<Bits>(b) & ~mask));
}

/// A point of the disk of radius 1, uniform by area.  It maps concentric squares to concentric
/// circles.  [Shirley97]
template <std::floating_point T>
BasicVec2<T> sample_concentric_disk(BasicVec2<T> u) {
  const T a = 2 * u.x - 1;
  const T b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {};
  constexpr T kQuarterPi = std::numbers::pi_v<T> / 4;
  const bool wide = std::fabs(a) > std::fabs(b);
  const T r = select(wide, a, b);
  const T phi = kQuarterPi * (select(wide, b, a) / r);
  const T along = r * std::cos(phi), across = r * std::sin(phi);
  return {select(wide, along, across), select(wide, across, along)};
}

/// For a disk of `radius` [m] (1 for the warp itself).
inline AreaPdf concentric_disk_pdf(double radius = 1) {
  return {std::numbers::inv_pi / radius / radius};
}

/// Barycentric coordinates, not negative, with sum 1; uniform by area.  The map is continuous and
/// folds the square along its diagonal.  [Heitz19]
inline Vec3 sample_uniform_triangle(Vec2 u) {
  const double low = std::min(u.x, u.y) / 2;
  const double high = std::max(u.x, u.y) - low;
  // In this order, the sum of all three is exactly 1, and the third is not negative.
  const double third = std::max(0.0, 1 - low - high);
  return u.x < u.y ? Vec3{low, high, third} : Vec3{high, low, third};
}

/// The same by the square root of one value.  [Turk90]
Vec3 sample_triangle_square_root(Vec2 u);
/// The same by the order of the values, after Kraemer: the lengths of a stick broken at two points.
/// [Devroye86, V.2]
Vec3 sample_triangle_kraemer(Vec2 u);
/// The same by a parallelogram, whose far half is turned about its middle.  [Turk90]
Vec3 sample_triangle_parallelogram(Vec2 u);
/// The same by a parallelogram whose far half is drawn again from hashes of `u`.  The point is a
/// function of `u`, but not a continuous one.
Vec3 sample_triangle_rejection(Vec2 u);
/// Any of the five; sample_uniform_triangle for other ways.
Vec3 sample_triangle(AreaSampling way, Vec2 u);

/// For a triangle of area `area_m2`; 1/2 for the triangle of the coordinates.
inline AreaPdf uniform_triangle_pdf(double area_m2) { return {1 / area_m2}; }

/// x in [0, 1] with density proportional to (1 - x) a + x b, for a, b >= 0.
inline double sample_linear(double u, double a, double b) {
  if (!(a + b > 0)) return u;
  return std::min(u * (a + b) / (a + std::sqrt((1 - u) * a * a + u * b * b)), 1.0);
}

/// Weights >= 0 at the corners of the unit square, bilinear between them.  [Pharr23, 2.4]
struct BilinearWeights {
  double w00, w10, w01, w11;

  double mean() const { return ((w00 + w10) + (w01 + w11)) / 4; }
  double at(double x, double y) const {
    return (1 - y) * ((1 - x) * w00 + x * w10) + y * ((1 - x) * w01 + x * w11);
  }
  /// A point of the unit square with the density at(x, y) / mean().
  Vec2 sample(Vec2 u) const {
    const double y = sample_linear(u.y, w00 + w10, w01 + w11);
    return {sample_linear(u.x, (1 - y) * w00 + y * w01, (1 - y) * w10 + y * w11), y};
  }
  double pdf(Vec2 p) const { return at(p.x, p.y) / mean(); }
};

}  // namespace lucerna

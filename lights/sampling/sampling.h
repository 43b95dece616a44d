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
template <std::floating_point Real>
Vec3<Real> sample_uniform_sphere(Vec2<Real> u) {
  const Real r = 2 * std::sqrt(u.x * (1 - u.x));
  const Real phi = 2 * std::numbers::pi_v<Real> * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - 2 * u.x};
}

template <std::floating_point Real>
SolidAnglePdf<Real> uniform_sphere_pdf() {
  return {std::numbers::inv_pi_v<Real> / 4};
}

/// A unit vector within an angle theta of +z, uniform in solid angle.  `one_minus_cos` is 1 -
/// cos(theta), in [0, 2].  Compute it as sin^2 / (1 + cos) or 2 sin^2(theta / 2), because the
/// difference cancels for narrow cones.
template <std::floating_point Real>
Vec3<Real> sample_uniform_cone(Vec2<Real> u, Real one_minus_cos) {
  const Real h = u.x * one_minus_cos;
  const Real r = std::sqrt(std::max(Real(0), h * (2 - h)));
  const Real phi = 2 * std::numbers::pi_v<Real> * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - h};
}

/// The density within the cone; infinite if the cone has no extent.
template <std::floating_point Real>
SolidAnglePdf<Real> uniform_cone_pdf(Real one_minus_cos) {
  return {std::numbers::inv_pi_v<Real> / (2 * one_minus_cos)};
}

/// `a` if `first`, else `b`.  Without a branch, for choices that no processor can predict.
template <std::floating_point Real>
Real select(bool first, Real a, Real b) {
  using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
  const Bits mask = first ? ~Bits{0} : Bits{0};
  return std::bit_cast<Real>((std::bit_cast<Bits>(a) & mask) | (std::bit_cast<Bits>(b) & ~mask));
}

/// A point of the disk of radius 1, uniform by area.  It maps concentric squares to concentric
/// circles.  [Shirley97]
template <std::floating_point Real>
Vec2<Real> sample_concentric_disk(Vec2<Real> u) {
  const Real a = 2 * u.x - 1;
  const Real b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {};
  constexpr Real kQuarterPi = std::numbers::pi_v<Real> / 4;
  const bool wide = std::fabs(a) > std::fabs(b);
  const Real r = select(wide, a, b);
  const Real phi = kQuarterPi * (select(wide, b, a) / r);
  const Real along = r * std::cos(phi), across = r * std::sin(phi);
  return {select(wide, along, across), select(wide, across, along)};
}

/// For a disk of `radius` [m] (1 for the warp itself).
template <std::floating_point Real>
AreaPdf<Real> concentric_disk_pdf(Real radius = 1) {
  return {std::numbers::inv_pi_v<Real> / radius / radius};
}

/// Barycentric coordinates, not negative, with sum 1; uniform by area.  The map is continuous and
/// folds the square along its diagonal.  [Heitz19]
template <std::floating_point Real>
Vec3<Real> sample_uniform_triangle(Vec2<Real> u) {
  const Real low = std::min(u.x, u.y) / 2;
  const Real high = std::max(u.x, u.y) - low;
  // In this order, the sum of all three is exactly 1, and the third is not negative.
  const Real third = std::max(Real(0), 1 - low - high);
  return u.x < u.y ? Vec3<Real>{low, high, third} : Vec3<Real>{high, low, third};
}

/// The same by the square root of one value.  [Turk90]
Vec3<double> sample_triangle_square_root(Vec2<double> u);
/// The same by the order of the values, after Kraemer: the lengths of a stick broken at two points.
/// [Devroye86, V.2]
Vec3<double> sample_triangle_kraemer(Vec2<double> u);
/// The same by a parallelogram, whose far half is turned about its middle.  [Turk90]
Vec3<double> sample_triangle_parallelogram(Vec2<double> u);
/// The same by a parallelogram whose far half is drawn again from hashes of `u`.  The point is a
/// function of `u`, but not a continuous one.
Vec3<double> sample_triangle_rejection(Vec2<double> u);
/// Any of the five; sample_uniform_triangle for other ways.
Vec3<double> sample_triangle(AreaSampling way, Vec2<double> u);

/// For a triangle of area `area_m2`; 1/2 for the triangle of the coordinates.
template <std::floating_point Real>
AreaPdf<Real> uniform_triangle_pdf(Real area_m2) {
  return {1 / area_m2};
}

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
  Vec2<double> sample(Vec2<double> u) const {
    const double y = sample_linear(u.y, w00 + w10, w01 + w11);
    return {sample_linear(u.x, (1 - y) * w00 + y * w01, (1 - y) * w10 + y * w11), y};
  }
  double pdf(Vec2<double> p) const { return at(p.x, p.y) / mean(); }
};

}  // namespace lucerna

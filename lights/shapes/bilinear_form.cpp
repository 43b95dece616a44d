#include "lights/shapes/bilinear_form.h"

#include <cmath>
#include <limits>

#include "lights/maths/gauss.h"

namespace lucerna {
namespace {

/// A square of (u, v).
struct Square {
  double u, v, size;  ///< its lower corner and its side

  Square quarter(int i) const {
    const double half = size / 2;
    return {u + half * (i & 1), v + half * (i >> 1), half};
  }
};

/// A bound on the error of Gauss's rule of four nodes for the mean of |N| over a line of (u, v). On
/// the line N = dp/du x dp/dv changes by `change`, and its length is from `least` to `most`.
///
/// The length of N is the root of a quadratic.  Its complex zeros have at least the distance least
/// / change from every point of the line (length 1).  So it is analytic in the ellipse around the
/// line with that shorter half axis, where it is at most most + least. [Trefethen20, theorem 19.3]
double gauss_error(double change, double least, double most) {
  if (!(change > 0)) return 0;
  const double half_axis = 2 * least / change;  // in half lengths of the line
  const double rho = half_axis + std::sqrt(half_axis * half_axis + 1);
  return 32.0 / 15 * (most + least) * std::pow(rho, -8) / (1 - 1 / (rho * rho));
}

/// The integral of |dp/du x dp/dv| over a square by 4 x 4 Gauss points.
BilinearPatchArea by_gauss(const BilinearForm& p, const Square& at) {
  const Gauss<4>& rule = gauss<4>();
  double mean = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      mean += rule.weight[i] * rule.weight[j] *
              length(p.area_vector(at.u + at.size * rule.node[i], at.v + at.size * rule.node[j]));

  const Vec3 middle = p.area_vector(at.u + at.size / 2, at.v + at.size / 2);
  const Vec3 side = normalized(middle);
  double least = std::numeric_limits<double>::infinity(), most = 0, sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Vec3 n = p.area_vector(at.u + at.size * (i & 1), at.v + at.size * (i >> 1));
    const double size = length(n);
    least = std::fmin(least, dot(n, side)), most = std::fmax(most, size), sum += size;
  }
  least = std::fmax(least, 0);
  const double by_continuation = gauss_error(at.size * length(cross(p.e, p.g)), least, most) +
                                 gauss_error(at.size * length(cross(p.g, p.f)), least, most);
  // The vector is linear, so its length is convex.  Integral and rule both lie between the length
  // at the middle and the mean of the lengths at the corners.
  const double by_convexity = std::fmax(mean - length(middle), sum / 4 - mean);
  const double error = std::fmax(0, std::fmin(by_continuation, by_convexity));
  return {mean * at.size * at.size, error * at.size * at.size};
}

/// Quarters the square until its error is at most `tolerance` [m2].  `depth` limits the time for
/// folded patches, whose integrand has kinks along lines.
BilinearPatchArea integrate(const BilinearForm& p, const Square& at, double tolerance, int depth) {
  const BilinearPatchArea whole = by_gauss(p, at);
  if (depth == 0 || whole.error_m2 <= tolerance) return whole;
  BilinearPatchArea sum;
  for (int i = 0; i < 4; ++i) {
    const BilinearPatchArea part = integrate(p, at.quarter(i), tolerance / 4, depth - 1);
    sum.m2 += part.m2, sum.error_m2 += part.error_m2;
  }
  return sum;
}

}  // namespace

BilinearPatchArea integrate_area(const BilinearForm& patch, double tolerance_m2) {
  constexpr int kDepth = 8;
  return integrate(patch, {0, 0, 1}, tolerance_m2, kDepth);
}

}  // namespace lucerna

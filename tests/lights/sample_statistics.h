// Statistics for tests of samplers: random numbers with a fixed seed, the chi-square test, and
// quadrature over the sphere.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna::testing {

/// The verdict of a checker: the text of the failure, or empty.  It is a result and not an
/// assertion, so that companions can assert that a wrong input is rejected.
struct Verdict {
  std::string failure;
  bool ok() const { return failure.empty(); }
};

/// Uniform multiples of 2^-24 in [0, 1); the same on every standard library.
class RandomU {
 public:
  explicit RandomU(std::uint64_t seed) : engine_(seed) {}
  float next() { return static_cast<float>(engine_() >> 40) * 0x1p-24F; }
  Vec2 pair() {
    const double x = next();
    return {x, next()};
  }

 private:
  std::mt19937_64 engine_;
};

/// The regularised upper incomplete gamma function Q(a, x): by its series below a + 1, by its
/// continued fraction above (modified Lentz).  [DLMF, 8.11.4 and 8.9.2]
inline double upper_gamma_q(double a, double x) {
  if (x <= 0) return 1;
  const double front = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 10000 && term > sum * 1e-16; ++n) sum += term *= x / (a + n);
    return 1 - front * sum;
  }
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
  for (int n = 1; n < 10000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = 1 / std::copysign(std::fmax(std::fabs(an * d + b), kTiny), an * d + b);
    c = b + an / c;
    h *= d * c;
    if (std::fabs(d * c - 1) < 1e-15) break;
  }
  return front * h;
}

/// The chi-square p-value of `observed` counts against `expected` ones.  Neighbouring bins are
/// pooled until each has at least 8 expected counts, where the chi-square distribution is accurate.
/// The fixed total takes one degree of freedom.
inline double chi_square_p_value(const std::vector<double>& observed,
                                 const std::vector<double>& expected) {
  struct Bin {
    double observed = 0, expected = 0;
  };
  std::vector<Bin> bins(1);
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (bins.back().expected >= 8) bins.emplace_back();
    bins.back().observed += observed[i];
    bins.back().expected += expected[i];
  }
  // The remaining counts are too few for a bin.  They may lie in a sliver that the quadrature of
  // `expected` misses.
  if (bins.size() > 1 && bins.back().expected < 8) {
    const Bin rest = bins.back();
    bins.pop_back();
    bins.back().observed += rest.observed;
    bins.back().expected += rest.expected;
  }
  double statistic = 0;
  for (const Bin& bin : bins) {
    const double difference = bin.observed - bin.expected;
    if (bin.expected > 0)
      statistic += difference * difference / bin.expected;
    else if (bin.observed > 0)
      statistic = INFINITY;
  }
  if (!std::isfinite(statistic)) return 0;
  return upper_gamma_q(std::fmax(1, static_cast<double>(bins.size()) - 1) / 2, statistic / 2);
}

/// A part of the sphere of directions: all within `half_angle` of the unit vector `axis`, cut into
/// cells of equal solid angle.
struct Region {
  Vec3 axis{0, 0, 1};
  double half_angle_rad = std::numbers::pi;

  double one_minus_cos() const {
    const double s = std::sin(half_angle_rad / 2);
    return 2 * s * s;
  }
  double solid_angle_sr() const { return 2 * std::numbers::pi * one_minus_cos(); }

  /// The direction at (x, y) of the unit square, uniform in solid angle.
  Vec3 at(double x, double y) const {
    const double h = x * one_minus_cos();
    const double r = std::sqrt(std::fmax(0, h * (2 - h)));
    const double phi = 2 * std::numbers::pi * y;
    return Frame::around(axis).world_from_local({r * std::cos(phi), r * std::sin(phi), 1 - h});
  }

  /// The inverse of `at`; x above 1 is outside of the region.
  Vec2 where(const Vec3& w) const {
    const Vec3 chord = w - axis;
    const Vec3 local = Frame::around(axis).local_from_world(w);
    const double y = std::atan2(local.y, local.x) / (2 * std::numbers::pi);
    return {dot(chord, chord) / 2 / one_minus_cos(), y < 0 ? y + 1 : y};
  }
};

/// The integral over the region of `f(w)`, by the midpoint rule on n x n cells of equal solid
/// angle.
template <typename F>
auto integrate(const Region& region, int n, F&& f) {
  auto sum = f(region.axis) * 0.0;
  for (int i = 0; i < n; ++i) {
    auto row = sum * 0.0;
    for (int j = 0; j < n; ++j) row = row + f(region.at((i + 0.5) / n, (j + 0.5) / n));
    sum = sum + row;
  }
  return sum * (region.solid_angle_sr() / n / n);
}

}  // namespace lucerna::testing

// Goniometric lights for the contract suites.  They hang as luminaires do: light space's +z is the
// world's -z, so that gamma is counted from straight down and C counter-clockwise seen from above.
#pragma once

#include "lights/goniometric_light.h"
#include "tests/lights/delta_cases.h"

namespace lucerna::testing {

/// A grid as a file holds it, read by hand: bilinear in gamma and C.
struct HandGrid {
  std::vector<double> gamma, c;  // degrees
  std::vector<double> cd;        // all gamma at the first C
  double value(std::size_t i, std::size_t j) const { return cd[i * gamma.size() + j]; }
  double at(double g, double h) const {
    if (g > gamma.back()) return 0;
    const auto cell = [](const std::vector<double>& grid, double x) {
      std::size_t i = 0;
      while (i + 2 < grid.size() && x > grid[i + 1]) ++i;
      return i;
    };
    const std::size_t j = cell(gamma, g);
    const double t = (g - gamma[j]) / (gamma[j + 1] - gamma[j]);
    if (c.size() == 1) return value(0, j) * (1 - t) + value(0, j + 1) * t;
    const std::size_t i = cell(c, h);
    const double s = (h - c[i]) / (c[i + 1] - c[i]);
    return (value(i, j) * (1 - t) + value(i, j + 1) * t) * (1 - s) +
           (value(i + 1, j) * (1 - t) + value(i + 1, j + 1) * t) * s;
  }
};

/// `Grid::grid()` says the intensities.
template <typename Grid>
struct WebCase : LocalDeltaCase {
  static constexpr double kDegree = std::numbers::pi / 180;
  template <typename Real>
  using Light = GoniometricLight<Real>;
  static Vec3<double> far_direction() { return {0, 0, -1}; }
  static GoniometricLightParams params(const Placement& placement) {
    const HandGrid g = Grid::grid();
    return {.position_m = placement.point(position()),
            .axes = {placement.direction({2, 0, 0}), placement.direction({0, -2, 0}),
                     placement.direction({0, 0, -2})},
            .intensity = kDeltaLevel,
            .web = *PhotometricWeb::create({PhotometricType::kC, g.gamma, g.c, g.cd})};
  }
  template <typename Real>
  static GoniometricLight<Real> make(const Placement& placement) {
    return *GoniometricLight<Real>::create(params(placement));
  }
  static std::vector<Vec3<double>> receivers() {
    return {{0.25, -0.5, -2}, {0.75, -0.25, -1}, {1, -0.75, -0.5}, {0, 0.5, -100}};
  }
  static double cd(const Vec3<double>& w) {
    const double g = std::atan2(std::hypot(w.x, w.y), -w.z) / kDegree;
    // Half of the planes are given, the plane 0-180 is one of symmetry.
    return Grid::grid().at(g, std::fabs(std::atan2(w.y, w.x)) / kDegree);
  }
  static Rgb<double> value(const Vec3<double>& receiver, const Vec3<double>& wi) {
    const Vec3<double> d = position() - receiver;
    return kDeltaLevel * (cd(-wi) / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  /// Simpson's rule within each cell, where the function is smooth.
  static Rgb<double> power_by_quadrature() {
    const HandGrid g = Grid::grid();
    const std::vector<double> c = g.c.size() > 1 ? g.c : std::vector<double>{0, 180};
    double sum = 0;
    for (std::size_t i = 0; i + 1 < c.size(); ++i)
      for (std::size_t j = 0; j + 1 < g.gamma.size(); ++j)
        sum += simpson(c[i], c[i + 1], 10, [&](double h) {
          return simpson(g.gamma[j], g.gamma[j + 1], 100, [&](double v) {
            return g.at(v, h) * std::sin(v * kDegree) * kDegree * kDegree;
          });
        });
    return kDeltaLevel * (2 * sum);
  }
};

struct UnevenGrid {
  static HandGrid grid() {
    return {{0, 30, 80, 180}, {0, 90, 180}, {9, 8, 3, 1, 9, 4, 6, 1, 9, 2, 5, 1}};
  }
};
struct DownGrid {
  static HandGrid grid() { return {{0, 40, 70, 90}, {0}, {100, 80, 0, 0}}; }
};
using UnevenWebCase = WebCase<UnevenGrid>;
using DownWebCase = WebCase<DownGrid>;

/// Without a web it is a point light.
struct IsotropicCase : PointCase {
  template <typename Real>
  using Light = GoniometricLight<Real>;
  template <typename Real>
  static GoniometricLight<Real> make(const Placement& placement) {
    return *GoniometricLight<Real>::create(
        {.position_m = placement.point(position()), .intensity = kDeltaLevel});
  }
};

}  // namespace lucerna::testing

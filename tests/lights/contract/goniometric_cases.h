// Goniometric lights for the contract suites.  They hang like luminaires: light space's +z is the
// world's -z.  So gamma counts from straight down, and C counter-clockwise as seen from above.
#pragma once

#include "lights/models/goniometric_light.h"
#include "tests/lights/contract/delta_cases.h"

namespace lucerna::testing {

/// A grid as in a file, looked up here: bilinear in gamma and C.
struct HandGrid {
  std::vector<double> gamma, c;  // degrees
  std::vector<double> cd;        // all gamma at the first C
  double value(std::size_t i, std::size_t j) const { return cd[i * gamma.size() + j]; }
  double at(double g, double h) const {
    if (g < gamma.front() || g > gamma.back()) return 0;
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

/// A direction by the type's angles V and H [degrees], from the standard's definitions, in light
/// space.
template <PhotometricType kType>
Vec2 photometric_angles(const Vec3& w) {
  constexpr double kDegree = std::numbers::pi / 180;
  switch (kType) {
    case PhotometricType::kC:  // from straight down, and to the left as seen from above
      return {std::atan2(std::hypot(w.x, w.y), w.z) / kDegree, std::atan2(-w.y, w.x) / kDegree};
    case PhotometricType::kB:  // from straight down towards +x; latitude towards +y
      return {std::atan2(w.x, w.z) / kDegree, std::atan2(w.y, std::hypot(w.x, w.z)) / kDegree};
    case PhotometricType::kA:  // latitude upwards; from +x towards +y
      return {std::atan2(-w.z, std::hypot(w.x, w.y)) / kDegree, std::atan2(w.y, w.x) / kDegree};
  }
  return {};
}

/// `Grid::grid()` returns the intensities.
template <typename Grid>
struct WebCase : LocalDeltaCase {
  static constexpr double kDegree = std::numbers::pi / 180;
  using Light = GoniometricLight;
  static Vec3 far_direction() { return {0, 0, -1}; }
  static GoniometricLightParams params(const Placement& placement) {
    const HandGrid g = Grid::grid();
    return {.position_m = placement.point(position()),
            .axes = {placement.direction({2, 0, 0}), placement.direction({0, -2, 0}),
                     placement.direction({0, 0, -2})},
            .intensity = kDeltaLevel,
            .web = *PhotometricWeb::create({Grid::kType, g.gamma, g.c, g.cd})};
  }
  static GoniometricLight make(const Placement& placement) {
    return *GoniometricLight::create(params(placement));
  }
  static std::vector<Vec3> receivers() {
    return {{0.25, -0.5, -2}, {0.75, -0.25, -1}, {1, -0.75, -0.5}, {0, 0.5, -100}};
  }
  static double cd(const Vec3& w) {
    const auto [v, h] = photometric_angles<Grid::kType>({w.x, -w.y, -w.z});
    // Grids that start at 0 are symmetric about it.  Types A and B end at 90.
    const double given = Grid::grid().c.front() == 0 ? std::fabs(h) : h;
    return Grid::kType != PhotometricType::kC && std::fabs(h) > 90 ? 0 : Grid::grid().at(v, given);
  }
  static Rgb value(const Vec3& receiver, const Vec3& wi) {
    const Vec3 d = position() - receiver;
    return kDeltaLevel * (cd(-wi) / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  /// Simpson's rule within each cell, where the function is smooth.  The solid angle's element is
  /// proportional to the sine of an angle from a pole, or to the cosine of a latitude.
  static Rgb power_by_quadrature() {
    const HandGrid g = Grid::grid();
    const std::vector<double> c = g.c.size() > 1 ? g.c : std::vector<double>{0, 180};
    double sum = 0;
    for (std::size_t i = 0; i + 1 < c.size(); ++i)
      for (std::size_t j = 0; j + 1 < g.gamma.size(); ++j)
        sum += simpson(c[i], c[i + 1], 100, [&](double h) {
          return simpson(g.gamma[j], g.gamma[j + 1], 100, [&](double v) {
            const double element = Grid::kType == PhotometricType::kC   ? std::sin(v * kDegree)
                                   : Grid::kType == PhotometricType::kB ? std::cos(h * kDegree)
                                                                        : std::cos(v * kDegree);
            return g.at(v, h) * element * kDegree * kDegree;
          });
        });
    return kDeltaLevel * (c.front() == 0 ? 2 * sum : sum);
  }
};

struct UnevenGrid {
  static constexpr PhotometricType kType = PhotometricType::kC;
  static HandGrid grid() {
    return {{0, 30, 80, 180}, {0, 90, 180}, {9, 8, 3, 1, 9, 4, 6, 1, 9, 2, 5, 1}};
  }
};
struct DownGrid {
  static constexpr PhotometricType kType = PhotometricType::kC;
  static HandGrid grid() { return {{0, 40, 70, 90}, {0}, {100, 80, 0, 0}}; }
};
/// Measured like a floodlight, symmetric about H = 0.
struct FloodGrid {
  static constexpr PhotometricType kType = PhotometricType::kB;
  static HandGrid grid() {
    return {{-90, -30, 10, 90}, {0, 40, 90}, {4, 6, 8, 5, 3, 7, 9, 5, 6, 6, 6, 6}};
  }
};
/// Measured like a headlamp, each side separately.
struct HeadlampGrid {
  static constexpr PhotometricType kType = PhotometricType::kA;
  static HandGrid grid() {
    return {
        {-90, -20, 15, 90}, {-90, -30, 20, 90}, {4, 6, 8, 5, 4, 7, 9, 5, 4, 9, 6, 5, 4, 3, 5, 5}};
  }
};
using UnevenWebCase = WebCase<UnevenGrid>;
using DownWebCase = WebCase<DownGrid>;
using FloodWebCase = WebCase<FloodGrid>;
/// It emits along +x.
struct HeadlampWebCase : WebCase<HeadlampGrid> {
  static Vec3 far_direction() { return {1, 0, 0}; }
  static std::vector<Vec3> receivers() {
    return {{2, -0.5, 1}, {1, -0.75, -0.5}, {3, 1, 2}, {0.75, 0, 1.25}};
  }
};

/// Without a web it is a point light.
struct IsotropicCase : PointCase {
  using Light = GoniometricLight;
  static GoniometricLight make(const Placement& placement) {
    return *GoniometricLight::create(
        {.position_m = placement.point(position()), .intensity = kDeltaLevel});
  }
};

}  // namespace lucerna::testing

// Goniometric lights with pictures for the contract suites, hung as those with webs are: the map's
// +z is the world's -z.  What each shows is worked out here from the mappings' definitions.
#pragma once

#include <array>

#include "lights/goniometric_light.h"
#include "tests/lights/delta_cases.h"

namespace lucerna::testing {

template <typename Map>
struct MapLightCase : LocalDeltaCase {
  template <typename Real>
  using Light = GoniometricLight<Real>;
  static Vec3<double> far_direction() { return {0, 0, -1}; }
  static Vec3<double> map_from_world(const Vec3<double>& w) { return {w.x, -w.y, -w.z}; }
  static GoniometricLightParams params(const Placement& placement) {
    // Colours whose mean is the value, so that a channel alone is something else.
    std::vector<Rgb<float>> texels;
    for (const float v : Map::kValues) texels.emplace_back(v, 0.0F, 2 * v);
    return {
        .position_m = placement.point(position()),
        .axes = {placement.direction({2, 0, 0}), placement.direction({0, -2, 0}),
                 placement.direction({0, 0, -2})},
        .intensity = kDeltaLevel,
        .map = *IntensityMap::create(*Image::create(Map::kWidth, Map::kHeight, std::move(texels)),
                                     Map::kMapping, Map::kFilter)};
  }
  template <typename Real>
  static GoniometricLight<Real> make(const Placement& placement) {
    return *GoniometricLight<Real>::create(params(placement));
  }
  static std::vector<Vec3<double>> receivers() {
    return {{0.25, -0.5, -2}, {0.75, -0.25, -1}, {0.75, -0.75, -0.5}, {0.5, -0.75, 0.25}};
  }
  static Rgb<double> value(const Vec3<double>& receiver, const Vec3<double>& wi) {
    const Vec3<double> d = position() - receiver;
    return kDeltaLevel *
           (Map::at(map_from_world(-wi)) / dot(d, d) + zero_if_towards(position(), receiver, wi));
  }
  static Rgb<double> power_by_quadrature() { return kDeltaLevel * Map::integral(); }
};

/// The nearest filter on equal areas: the radius goes as the sine of half the polar angle, the
/// other coordinate with the azimuth in its quadrant, and the lower half is folded outwards.
template <typename Grid>
struct EqualAreaNearest : Grid {
  static constexpr SphereMapping kMapping = SphereMapping::kEqualArea;
  static constexpr ImageFilter kFilter = ImageFilter::kNearest;
  static double at(const Vec3<double>& w) {
    const double theta = std::atan2(std::hypot(w.x, w.y), std::fabs(w.z));
    const double r = std::numbers::sqrt2 * std::sin(theta / 2);
    const double azimuth = std::atan2(std::fabs(w.y), std::fabs(w.x)) / (kPi / 2);
    double a = r * (1 - azimuth), b = r * azimuth;
    if (w.z < 0) {
      const double folded = 1 - b;
      b = 1 - a;
      a = folded;
    }
    const int n = Grid::kWidth;
    const auto column = [&](double x) { return std::min(n - 1, int((1 + x) / 2 * n)); };
    return Grid::kValues[static_cast<std::size_t>(column(std::copysign(b, w.y)) * n +
                                                  column(std::copysign(a, w.x)))];
  }
  /// Equal areas are equal solid angles, by the mapping's definition.
  static double integral() {
    double sum = 0;
    for (const float v : Grid::kValues) sum += v;
    return sum * 4 * kPi / (Grid::kWidth * Grid::kHeight);
  }
};

struct UnevenTexels {
  static constexpr int kWidth = 4, kHeight = 4;
  static constexpr std::array<float, 16> kValues{1, 2, 0, 4, 8, 1, 3, 0, 2, 5, 9, 1, 0, 1, 1, 30};
};
/// Lit within 0.7228 rad of the axis: the corners of the lit square lie at r = 1/2, and
/// cos theta = 1 - r^2.
struct ConfinedTexels {
  static constexpr int kWidth = 8, kHeight = 8;
  static constexpr std::array<float, 64> kValues = [] {
    std::array<float, 64> values{};
    values[27] = 1, values[28] = 2, values[35] = 3, values[36] = 4;
    return values;
  }();
};
using UnevenMapCase = MapLightCase<EqualAreaNearest<UnevenTexels>>;
using ConfinedMapCase = MapLightCase<EqualAreaNearest<ConfinedTexels>>;

/// The bilinear filter on latitudes and longitudes: +y up, longitude from +x by +z.
struct LatitudeLongitudeBilinear {
  static constexpr int kWidth = 6, kHeight = 4;
  static constexpr SphereMapping kMapping = SphereMapping::kLatitudeLongitude;
  static constexpr ImageFilter kFilter = ImageFilter::kBilinear;
  static constexpr std::array<float, 24> kValues{1, 2, 1, 4, 3, 1, 3, 2, 2, 5, 4, 1,
                                                 2, 1, 1, 3, 5, 2, 4, 4, 2, 1, 1, 3};
  static double texel(int x, int y) {
    if (y < 0 || y >= kHeight) {  // over the pole
      x += kWidth / 2;
      y = y < 0 ? 0 : kHeight - 1;
    }
    return kValues[static_cast<std::size_t>(y * kWidth + (x + kWidth) % kWidth)];
  }
  static double shown(double theta, double phi) {
    const double x = phi / (2 * kPi) * kWidth - 0.5, y = theta / kPi * kHeight - 0.5;
    const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
    double sum = 0;
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i)
        sum += texel(ix + i, iy + j) * (std::fabs(1 - i - (x - ix)) * std::fabs(1 - j - (y - iy)));
    return sum;
  }
  static double at(const Vec3<double>& w) {
    const double phi = std::atan2(w.z, w.x);
    return shown(std::atan2(std::hypot(w.x, w.z), w.y), phi < 0 ? phi + 2 * kPi : phi);
  }
  /// Between two rows of centres it is linear in theta; its mean over phi is that over the centres.
  static double integral() {
    double sum = 0;
    for (int strip = 0; strip < 2 * kHeight; ++strip)
      for (int x = 0; x < kWidth; ++x)
        sum += simpson(kPi * strip / (2 * kHeight), kPi * (strip + 1) / (2 * kHeight), 32,
                       [&](double theta) {
                         return shown(theta, 2 * kPi * (x + 0.5) / kWidth) * std::sin(theta);
                       }) *
               2 * kPi / kWidth;
    return sum;
  }
};
struct LatitudeLongitudeMapCase : MapLightCase<LatitudeLongitudeBilinear> {
  // A direction's rounding to float, 6e-8, times a slope of up to 4 in relative terms a radian,
  // both of value and of evaluation.
  static constexpr double kTolerance = 1e-6;
};

}  // namespace lucerna::testing

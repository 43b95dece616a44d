// Lights with a picture around the sphere, for the contract suites.
#pragma once

#include <cmath>
#include <numbers>

#include "lights/image_infinite_light.h"
#include "tests/lights/delta_cases.h"

namespace lucerna::testing {

inline const Rgb<double> kMapLevel{3, 5, 7};

/// Red, green and blue of texel i differ, so that a channel at the wrong place is seen.
inline Rgb<float> texel_of(float v, int i) {
  return {v, v * 0.5F, v * (1 + static_cast<float>(i % 3))};
}

inline std::shared_ptr<const SphereMap> map_of(int width, int height,
                                               const std::vector<float>& values,
                                               SphereMapping mapping, ImageFilter filter) {
  std::vector<Rgb<float>> texels;
  for (std::size_t i = 0; i < values.size(); ++i)
    texels.push_back(texel_of(values[i], static_cast<int>(i)));
  return *SphereMap::create(*Image::create(width, height, std::move(texels)), mapping, filter);
}

struct MapCase : CaseDefaults {
  template <typename Real>
  using Light = ImageInfiniteLight<Real>;
  static std::vector<Vec3<double>> receivers() { return {{0, 0, 0}, {1e6, -3, 5}}; }
  static Region region(const Vec3<double>&) { return {}; }
  static double scene_disk_m2() { return 16 * kPi; }
};

/// 4 x 4 texels, some black; the nearest filter.
struct EqualAreaCase : MapCase {
  static constexpr std::array<float, 16> kValues{1, 2, 0, 4, 8, 1, 3, 0, 2, 5, 9, 1, 0, 1, 1, 30};
  static std::shared_ptr<const SphereMap> map() {
    return map_of(4, 4, {kValues.begin(), kValues.end()}, SphereMapping::kEqualArea,
                  ImageFilter::kNearest);
  }
  template <typename Real>
  static ImageInfiniteLight<Real> make(const Placement& placement) {
    return *ImageInfiniteLight<Real>::create(
        {.map = map(), .world_from_map = placement.rigid, .radiance_cd_m2 = kMapLevel});
  }
  /// From the angles: the radius goes as the sine of half the polar angle, the other coordinate
  /// with the azimuth within its quadrant.
  static Rgb<double> value(const Vec3<double>&, const Vec3<double>& w) {
    const double theta = std::atan2(std::hypot(w.x, w.y), std::fabs(w.z));
    const double r = std::numbers::sqrt2 * std::sin(theta / 2);
    const double azimuth = std::atan2(std::fabs(w.y), std::fabs(w.x)) / (kPi / 2);
    double a = r * (1 - azimuth), b = r * azimuth;
    if (w.z < 0) {
      const double folded = 1 - b;
      b = 1 - a;
      a = folded;
    }
    const double x = 0.5 + std::copysign(a / 2, w.x), y = 0.5 + std::copysign(b / 2, w.y);
    const int i = std::min(3, int(y * 4)) * 4 + std::min(3, int(x * 4));
    return kMapLevel * Rgb<double>(texel_of(kValues[static_cast<std::size_t>(i)], i));
  }
  /// Equal areas are equal solid angles, by the mapping's definition.
  static Rgb<double> power_by_quadrature() {
    Rgb<double> sum;
    for (int i = 0; i < 16; ++i)
      sum += Rgb<double>(texel_of(kValues[static_cast<std::size_t>(i)], i));
    return kMapLevel * sum * (4 * kPi / 16 * scene_disk_m2());
  }
};

/// 6 x 4 texels; the bilinear filter.
struct LatitudeLongitudeCase : MapCase {
  static constexpr int kWidth = 6, kHeight = 4;
  static constexpr std::array<float, 24> kValues{1, 2, 1, 4, 3, 1, 3, 2, 2, 5, 4, 1,
                                                 2, 1, 1, 3, 5, 2, 4, 4, 2, 1, 1, 3};
  static std::shared_ptr<const SphereMap> map() {
    return map_of(kWidth, kHeight, {kValues.begin(), kValues.end()},
                  SphereMapping::kLatitudeLongitude, ImageFilter::kBilinear);
  }
  template <typename Real>
  static ImageInfiniteLight<Real> make(const Placement& placement) {
    return *ImageInfiniteLight<Real>::create(
        {.map = map(), .world_from_map = placement.rigid, .radiance_cd_m2 = kMapLevel});
  }
  static Rgb<double> texel(int x, int y) {
    if (y < 0 || y >= kHeight) {  // over the pole
      x += kWidth / 2;
      y = y < 0 ? 0 : kHeight - 1;
    }
    const int i = y * kWidth + (x + kWidth) % kWidth;
    return Rgb<double>(texel_of(kValues[static_cast<std::size_t>(i)], i));
  }
  static Rgb<double> shown(double theta, double phi) {
    const double x = phi / (2 * kPi) * kWidth - 0.5, y = theta / kPi * kHeight - 0.5;
    const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
    Rgb<double> sum;
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i)
        sum += texel(ix + i, iy + j) * (std::fabs(1 - i - (x - ix)) * std::fabs(1 - j - (y - iy)));
    return sum;
  }
  static Rgb<double> value(const Vec3<double>&, const Vec3<double>& w) {
    const double phi = std::atan2(w.z, w.x);
    return kMapLevel * shown(std::atan2(std::hypot(w.x, w.z), w.y), phi < 0 ? phi + 2 * kPi : phi);
  }
  /// Strip by strip, in which it is linear in theta; the mean over phi is that over the centres.
  static Rgb<double> power_by_quadrature() {
    Rgb<double> sum;
    for (int strip = 0; strip < 2 * kHeight; ++strip) {
      const double a = kPi * strip / (2 * kHeight), h = kPi / (2 * kHeight) / 64;
      for (int k = 0; k <= 64; ++k) {
        const double theta = a + k * h;
        const double weight = (k == 0 || k == 64 ? 1 : k % 2 == 1 ? 4 : 2) * h / 3;
        for (int x = 0; x < kWidth; ++x)
          sum += shown(theta, 2 * kPi * (x + 0.5) / kWidth) *
                 (weight * std::sin(theta) * 2 * kPi / kWidth);
      }
    }
    return kMapLevel * sum * scene_disk_m2();
  }
};

}  // namespace lucerna::testing

// Pictures around the sphere, computed from the definitions of the mappings and filters alone.  The
// tests compare lights that have such pictures with them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "lights/pictures/sphere_map.h"

namespace lucerna::testing {

/// The radius is proportional to the sine of half the polar angle from +z.  The other coordinate is
/// proportional to the azimuth in its quadrant.  The lower half is folded outwards.
struct EqualArea {
  static constexpr SphereMapping kMapping = SphereMapping::kEqualArea;

  static Vec2 square(const Vec3& w) {
    const double theta = std::atan2(std::hypot(w.x, w.y), std::fabs(w.z));
    const double r = std::numbers::sqrt2 * std::sin(theta / 2);
    const double azimuth = std::atan2(std::fabs(w.y), std::fabs(w.x)) / (std::numbers::pi / 2);
    double a = r * (1 - azimuth), b = r * azimuth;
    if (w.z < 0) {
      const double folded = 1 - b;
      b = 1 - a;
      a = folded;
    }
    return {0.5 + std::copysign(a / 2, w.x), 0.5 + std::copysign(b / 2, w.y)};
  }
  /// The two halves of each edge are one line on the sphere.  A point beyond it is at the same
  /// distance from the edge's middle on its other side.
  static int beyond_border(int x, int y, int width, int height) {
    const bool beside = x < 0 || x >= width, above_or_below = y < 0 || y >= height;
    const int column = std::clamp(x, 0, width - 1), row = std::clamp(y, 0, height - 1);
    return (beside ? height - 1 - row : row) * width +
           (above_or_below ? width - 1 - column : column);
  }
  /// The mean, for every filter: equal areas are equal solid angles.  At each edge, the part of a
  /// texel's share that is cut off equals the part that the texel beyond it adds.
  template <ImageFilter kFilter, typename Texel>
  static auto integral(int width, int height, Texel&& texel) {
    auto sum = texel(0) * 0.0;
    for (int i = 0; i < width * height; ++i) sum = sum + texel(i);
    return sum * (4 * std::numbers::pi / (width * height));
  }
};

/// +y up, longitude from +x by +z.
struct LatitudeLongitude {
  static constexpr SphereMapping kMapping = SphereMapping::kLatitudeLongitude;

  static Vec2 square(const Vec3& w) {
    const double turn = std::atan2(w.z, w.x) / (2 * std::numbers::pi);
    return {turn < 0 ? turn + 1 : turn, std::atan2(std::hypot(w.x, w.z), w.y) / std::numbers::pi};
  }
  /// Left and right meet.  Beyond a pole lies the meridian half a turn away.
  static int beyond_border(int x, int y, int width, int height) {
    if (y < 0 || y >= height) x += width / 2;
    return std::clamp(y, 0, height - 1) * width + (x + width) % width;
  }
  /// Along a row the mean is that over its texels' centres.  A row of texels between two polar
  /// angles theta has the weight cos(begin) - cos(end).  Between two rows of centres the integrand
  /// is linear in theta times its sine.  Simpson's rule on 64 intervals integrates it to 1e-10.
  template <ImageFilter kFilter, typename Texel>
  static auto integral(int width, int height, Texel&& texel) {
    const double step = std::numbers::pi / height;
    const auto row_sum = [&](int y) {
      auto sum = texel(0) * 0.0;
      for (int x = 0; x < width; ++x) sum = sum + texel(std::clamp(y, 0, height - 1) * width + x);
      return sum;
    };
    auto sum = texel(0) * 0.0;
    for (int y = 0; kFilter == ImageFilter::kNearest && y < height; ++y)
      sum = sum + row_sum(y) * (std::cos(step * y) - std::cos(step * (y + 1)));
    // From the middle of row y - 1 to that of row y, or from or to a pole.
    for (int y = 0; kFilter == ImageFilter::kBilinear && y <= height; ++y) {
      const double begin = std::fmax(0, step * (y - 0.5));
      const double end = std::fmin(std::numbers::pi, step * (y + 0.5));
      const double h = (end - begin) / 64;
      for (int k = 0; k <= 64; ++k) {
        const double theta = begin + k * h, share = theta / step + 0.5 - y;
        const double weight = (k == 0 || k == 64 ? 1 : k % 2 == 1 ? 4 : 2) * h / 3;
        sum =
            sum + (row_sum(y - 1) * (1 - share) + row_sum(y) * share) * (weight * std::sin(theta));
      }
    }
    return sum * (2 * std::numbers::pi / width);
  }
};

/// A grid of texels (`kWidth`, `kHeight`, `kValues` by rows) under a mapping and a filter.
/// `texel(i)` makes a number or a colour of the i-th.
template <typename Mapping, ImageFilter kWith, typename Grid>
struct Mapped : Grid {
  static constexpr SphereMapping kMapping = Mapping::kMapping;
  static constexpr ImageFilter kFilter = kWith;

  template <typename Texel>
  static auto shown(const Vec3& w, Texel&& texel) {
    const Vec2 p = Mapping::square(w);
    const double x = p.x * Grid::kWidth, y = p.y * Grid::kHeight;
    if constexpr (kWith == ImageFilter::kNearest) {
      return texel(std::min(int(y), Grid::kHeight - 1) * Grid::kWidth +
                   std::min(int(x), Grid::kWidth - 1));
    } else {
      // Hats about the centres of the four nearest texels.
      const int left = int(std::floor(x - 0.5)), top = int(std::floor(y - 0.5));
      auto sum = texel(0) * 0.0;
      for (int row = top; row < top + 2; ++row)
        for (int column = left; column < left + 2; ++column)
          sum = sum + texel(Mapping::beyond_border(column, row, Grid::kWidth, Grid::kHeight)) *
                          ((1 - std::fabs(x - 0.5 - column)) * (1 - std::fabs(y - 0.5 - row)));
      return sum;
    }
  }
  /// The integral over all directions [sr].
  template <typename Texel>
  static auto integral(Texel&& texel) {
    return Mapping::template integral<kWith>(Grid::kWidth, Grid::kHeight, texel);
  }
};

/// From black to bright.
struct PatchySquare {
  static constexpr int kWidth = 4, kHeight = 4;
  static constexpr std::array<float, 16> kValues{1, 2, 0, 4, 8, 1, 3, 0, 2, 5, 9, 1, 0, 1, 1, 30};
};
struct PatchyPanorama {
  static constexpr int kWidth = 6, kHeight = 4;
  static constexpr std::array<float, 24> kValues{1, 2, 0, 4, 3,  1, 0, 2, 2, 5, 4, 1,
                                                 2, 9, 1, 0, 25, 2, 4, 0, 2, 1, 0, 3};
};
/// Lit everywhere, from 1 to 5.  So a bilinear filter changes by a bounded amount from one
/// direction to the next, in relative terms too.
struct GentleSquare {
  static constexpr int kWidth = 4, kHeight = 4;
  static constexpr std::array<float, 16> kValues{1, 2, 1, 4, 3, 1, 3, 2, 2, 5, 4, 1, 2, 1, 1, 3};
};
struct GentlePanorama {
  static constexpr int kWidth = 6, kHeight = 4;
  static constexpr std::array<float, 24> kValues{1, 2, 1, 4, 3, 1, 3, 2, 2, 5, 4, 1,
                                                 2, 1, 1, 3, 5, 2, 4, 4, 2, 1, 1, 3};
};

}  // namespace lucerna::testing

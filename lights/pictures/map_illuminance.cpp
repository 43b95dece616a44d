#include "lights/pictures/map_illuminance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// Least number of cells along an axis of the picture, and along the short axis of a strip.
constexpr int kLeast = 512, kFew = 64;

/// A cell of the picture, with bounds for the quadrature.
struct Cell {
  double measure;  ///< weight of its mean
  double density;  ///< factor of the cosine: 1, or the sine of a polar angle
  bool kinked;     ///< not smooth within
  /// Bounds on the mean difference from the value at the middle: for smooth cells, and for all
  /// cells.
  double second, first;
  double reach;  ///< bound on the change of the cosine within
};

/// Equal-area cells of half sides a and b of the square [-1, 1]^2, about (u, v).
///
/// In a quarter of the upper half, the direction is (rho cos phi, rho sin phi, 1 - r^2), with r = u
/// + v, phi = pi v / 2r and rho^2 = r^2 (2 - r^2).  The first derivatives by u and by v are at most
/// |(sqrt 2, pi / sqrt 2, 2)| < 3.4.  The second derivatives are less than |(7.5, 8.9, 2)| / r < 12
/// / r.  The lower half is the upper one folded over the diagonals.  Over a cell, the mean of |du|
/// + |dv| is (a + b) / 2, and the mean of its square is a^2 / 3 + b^2 / 3 + a b / 2.
Cell equal_area_cell(double u, double v, double a, double b) {
  const double sum = std::fabs(u) + std::fabs(v);
  const double r = (sum < 1 ? sum : 2 - sum) - (a + b);
  const double first = 1.7 * (a + b);
  const double second = 6 * (a * a / 3 + b * b / 3 + a * b / 2);
  const bool kinked = std::fabs(sum - 1) < a + b || std::fabs(u) < a || std::fabs(v) < b;
  return {4 * kPi * a * b, 1,        kinked, r > 0 ? std::min(first, second / r) : first,
          first,           2 * first};
}

/// Latitude-longitude cells of half sides a (polar angle) and b (azimuth phi), at the polar angle
/// theta. The derivatives of the direction are at most 1.  For the direction times sin theta, the
/// first derivatives are at most 1.  Its second derivatives are at most 2 by theta, 1 by phi and 1
/// mixed.  The cosine cut off at the plane, times sin theta, changes by at most 2 by theta and 1 by
/// phi.
Cell latitude_longitude_cell(double theta, double a, double b) {
  return {4 * a * b, std::sin(theta), false, a * a / 3 + b * b / 6 + a * b / 4, a + b / 2, a + b};
}

/// The edges of cells along one axis of the picture, from 0 to 1.  The filter is linear in each
/// cell.
std::vector<double> edges(int texels, ImageFilter filter, int least) {
  const int parts = (least + texels - 1) / texels;
  std::vector<double> at{0};
  const double n = texels;
  const auto add = [&](double end) {
    const double begin = at.back();
    for (int i = 1; i < parts; ++i) at.push_back(begin + (end - begin) * i / parts);
    at.push_back(end);
  };
  if (filter == ImageFilter::kBilinear)
    for (int i = 0; i < texels; ++i) add((i + 0.5) / n);
  else
    for (int i = 1; i < texels; ++i) add(i / n);
  add(1);
  return at;
}

}  // namespace

MapIlluminance illuminance_of(const SphereMap& map, const Rgb& radiance, const Vec3& n) {
  const bool nearest = map.filter() == ImageFilter::kNearest;
  const bool equal_area = map.mapping() == SphereMapping::kEqualArea;
  const auto value = [&](double x, double y) { return map.lookup(Vec2{x, y}) * radiance; };
  // Pictures of a few long rows or columns get fewer cells across, since 2^18 cells are enough.
  const auto least = [](int other) { return std::clamp(kLeast * kLeast / other, kFew, kLeast); };
  const int columns = map.image().width(), rows = map.image().height();
  const std::vector<double> xs = edges(columns, map.filter(), least(rows));
  const std::vector<double> ys = edges(rows, map.filter(), least(columns));
  // Luminances at the corners of a row of cells.  They bound the change of a bilinear map in a
  // cell.
  const auto corners = [&](double y) {
    std::vector<double> row;
    if (!nearest)
      for (const double x : xs) row.push_back(luminance(value(x, y)));
    return row;
  };
  MapIlluminance sum;
  std::vector<double> upper = corners(0), lower;
  StopPoll poll;
  for (std::size_t j = 0; j + 1 < ys.size(); ++j, upper = std::move(lower), poll()) {
    const double y = (ys[j] + ys[j + 1]) / 2, half_y = (ys[j + 1] - ys[j]) / 2;
    lower = corners(ys[j + 1]);
    MapIlluminance row;
    for (std::size_t i = 0; i + 1 < xs.size(); ++i, poll()) {
      const double x = (xs[i] + xs[i + 1]) / 2, half_x = (xs[i + 1] - xs[i]) / 2;
      const Cell cell = equal_area
                            ? equal_area_cell(2 * x - 1, 2 * y - 1, 2 * half_x, 2 * half_y)
                            : latitude_longitude_cell(kPi * y, kPi * half_y, 2 * kPi * half_x);
      const double cos = dot(n, direction_from_square(map.mapping(), {x, y}));
      if (cos < -cell.reach) continue;
      const Rgb at = value(x, y);
      row.lx += at * (std::max(0.0, cos) * cell.density * cell.measure);
      // Approximately the part of the cell above the plane.
      const double above = std::clamp(0.5 + cos / (2 * cell.reach), 0.0, 1.0);
      row.without_cosine += at * (above * cell.density * cell.measure);
      const double level = luminance(at);
      double astray = 0;
      if (!nearest)
        for (const double corner : {upper[i], upper[i + 1], lower[i], lower[i + 1]})
          astray = std::max(astray, std::fabs(corner - level));
      const bool smooth = !cell.kinked && cos > cell.reach;
      row.error_lx +=
          (level * (smooth ? cell.second : cell.first) + astray * cell.first) * cell.measure;
    }
    sum.lx += row.lx;
    sum.error_lx += row.error_lx;
    sum.without_cosine += row.without_cosine;
  }
  return sum;
}

}  // namespace lucerna

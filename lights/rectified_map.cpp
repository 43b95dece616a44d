#include "lights/rectified_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lucerna {
namespace {

constexpr double kPi = std::numbers::pi;

double angle(double c) { return (std::clamp(c, 0.0, 1.0) - 0.5) * kPi; }

/// The illuminance under radiance 1 between the axes and the angles alpha and beta, signed: a
/// rectangle above one of its corners.  [Howell20]
double corner_illuminance(double alpha, double beta) {
  const auto part = [](double a, double b) {
    // atan(tan(b) cos(a)), also where the tangent has no end.
    return std::sin(a) * std::atan2(std::sin(b) * std::cos(a), std::cos(b)) / 2;
  };
  return part(alpha, beta) + part(beta, alpha);
}

}  // namespace

Vec2<double> square_from_rectified(const Vec3<double>& w) {
  return {std::atan2(w.x, w.z) / kPi + 0.5, std::atan2(w.y, w.z) / kPi + 0.5};
}

Vec3<double> rectified_from_square(Vec2<double> p) {
  const double a = angle(p.x), b = angle(p.y);
  // Without tangents, which overflow at the ends.
  return normalized(Vec3<double>{std::sin(a) * std::cos(b), std::cos(a) * std::sin(b),
                                 std::cos(a) * std::cos(b)});
}

double sr_per_square(const Vec3<double>& w) {
  return kPi * kPi * (w.x * w.x + w.z * w.z) * (w.y * w.y + w.z * w.z) / w.z;
}

RectifiedMap::RectifiedMap(const SphereMap& map, const Vec3<double>& x, const Vec3<double>& y,
                           const Vec3<double>& z)
    : n_(map.image().height()) {
  texels_.reserve(static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_));
  for (int j = 0; j < n_; ++j)
    for (int i = 0; i < n_; ++i) {
      const Vec3<double> w = rectified_from_square({(i + 0.5) / n_, (j + 0.5) / n_});
      const Vec2<double> p =
          square_from_direction(map.mapping(), normalized(x * w.x + y * w.y + z * w.z));
      texels_.emplace_back(map.image().lookup(p, ImageFilter::kBilinear, map.border()));
    }
}

Rgb<double> RectifiedMap::lookup(Vec2<double> p) const {
  const auto cell = [&](double c) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(c * n_), 0, n_ - 1));
  };
  return Rgb<double>(texels_[cell(p.y) * static_cast<std::size_t>(n_) + cell(p.x)]);
}

MapIlluminance RectifiedMap::illuminance(const Rgb<double>& radiance) const {
  MapIlluminance sum;
  const auto corners = [&](int j) {
    std::vector<double> row;
    for (int i = 0; i <= n_; ++i)
      row.push_back(corner_illuminance(angle(i / double(n_)), angle(j / double(n_))));
    return row;
  };
  std::vector<double> upper = corners(0), lower;
  for (int j = 0; j < n_; ++j, upper = std::move(lower)) {
    lower = corners(j + 1);
    MapIlluminance row;
    for (int i = 0; i < n_; ++i) {
      const Vec2<double> middle{(i + 0.5) / n_, (j + 0.5) / n_};
      const Rgb<double> l = lookup(middle) * radiance;
      const auto c = static_cast<std::size_t>(i);
      row.lx += l * std::fmax(0, lower[c + 1] - lower[c] - upper[c + 1] + upper[c]);
      row.without_cosine += l * (sr_per_square(rectified_from_square(middle)) / n_ / n_);
    }
    sum.lx += row.lx;
    sum.without_cosine += row.without_cosine;
  }
  return sum;
}

}  // namespace lucerna

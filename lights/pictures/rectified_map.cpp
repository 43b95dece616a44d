#include "lights/pictures/rectified_map.h"

#include <algorithm>
#include <cmath>

#include "lights/maths/gauss.h"
#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

double angle(double c) { return (std::clamp(c, 0.0, 1.0) - 0.5) * kPi; }

/// Illuminance per area of the square of angles under radiance 1: the cosine of a direction times
/// its solid angle.  The parameters are sin(p)^2 and sin(q)^2 of the angles p and q from two
/// adjacent edges of the square.  All terms are positive, so nothing cancels.
double lx_per_area(double p2, double q2) {
  const double sum = p2 + q2 * (1 - p2);
  return p2 * q2 / (sum * sum);
}

/// The integral over a square of angles from (p, q) to (p + size, q + size) [rad].
///
/// Near each corner of [0, pi]^2 the function depends only on p / q.  For a real q, its nearest
/// pole in the complex plane of p is at least as far away as that corner.  So Gauss's rule of 12
/// nodes is exact to rounding for squares that are not larger than their distance from the corner.
/// Larger squares are halved.  After 26 halvings, the rest in the corner is 2^-52 of the square.
double corner_lx(double p, double q, double size, int halvings) {
  const auto off = [&](double at) { return std::max(0.0, std::min(at, kPi - (at + size))); };
  if (halvings > 0 && std::hypot(off(p), off(q)) < size) {
    const double half = size / 2;
    return corner_lx(p, q, half, halvings - 1) + corner_lx(p + half, q, half, halvings - 1) +
           corner_lx(p, q + half, half, halvings - 1) +
           corner_lx(p + half, q + half, half, halvings - 1);
  }
  const Gauss<12>& rule = gauss<12>();
  const auto squared_sine = [](double angle) {
    const double s = std::sin(angle);
    return s * s;
  };
  double sum = 0;
  for (std::size_t b = 0; b < rule.node.size(); ++b) {
    const double q2 = squared_sine(q + size * rule.node[b]);
    double line = 0;
    for (std::size_t a = 0; a < rule.node.size(); ++a)
      line += rule.weight[a] * lx_per_area(squared_sine(p + size * rule.node[a]), q2);
    sum += rule.weight[b] * line;
  }
  return size * size * sum;
}

}  // namespace

Vec2 square_from_rectified(const Vec3& w) {
  return {std::atan2(w.x, w.z) / kPi + 0.5, std::atan2(w.y, w.z) / kPi + 0.5};
}

Vec3 rectified_from_square(Vec2 p) {
  const double a = angle(p.x), b = angle(p.y);
  // Avoids tangents, which overflow at the ends.
  return normalized(
      Vec3{std::sin(a) * std::cos(b), std::cos(a) * std::sin(b), std::cos(a) * std::cos(b)});
}

double sr_per_square(const Vec3& w) {
  return kPi * kPi * (w.x * w.x + w.z * w.z) * (w.y * w.y + w.z * w.z) / w.z;
}

RectifiedCells::RectifiedCells(int n) : n_(n) {
  const int half = (n + 1) / 2;
  for (int i = 0; i < half; ++i)
    for (const double node : gauss<kNodes>().node) {
      const double s = std::sin(kPi * ((i + node) / n));
      squared_sine_.push_back(s * s);
    }
}

std::vector<double> RectifiedCells::row(int j) const {
  // For cells farther than this many cells from a corner, 5 nodes have an error of 1e-15.
  constexpr double kFar = 24;
  const Gauss<kNodes>& rule = gauss<kNodes>();
  const double size = kPi / n_;
  const int half = (n_ + 1) / 2, from_edge = std::min(j, n_ - 1 - j);
  const double* q2 = &squared_sine_[static_cast<std::size_t>(from_edge) * kNodes];
  std::vector<double> lx(static_cast<std::size_t>(n_));
  StopPoll poll;
  for (int i = 0; i < half; ++i, poll()) {
    double of_cell = 0;
    if (std::hypot(i, from_edge) < kFar) {
      constexpr int kHalvings = 26;
      of_cell = corner_lx(size * i, size * from_edge, size, kHalvings);
    } else {
      const double* p2 = &squared_sine_[static_cast<std::size_t>(i) * kNodes];
      for (std::size_t b = 0; b < kNodes; ++b)
        for (std::size_t a = 0; a < kNodes; ++a)
          of_cell += rule.weight[a] * rule.weight[b] * lx_per_area(p2[a], q2[b]);
      of_cell *= size * size;
    }
    lx[static_cast<std::size_t>(i)] = lx[static_cast<std::size_t>(n_ - 1 - i)] = of_cell;
  }
  return lx;
}

RectifiedMap::RectifiedMap(const SphereMap& map, const Vec3& x, const Vec3& y, const Vec3& z)
    : n_(map.image().height()) {
  texels_.reserve(static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_));
  StopPoll poll;
  for (int j = 0; j < n_; ++j)
    for (int i = 0; i < n_; ++i, poll()) {
      const Vec3 w = rectified_from_square({(i + 0.5) / n_, (j + 0.5) / n_});
      const Vec2 p = square_from_direction(map.mapping(), normalized(x * w.x + y * w.y + z * w.z));
      texels_.emplace_back(map.image().lookup(p, ImageFilter::kBilinear, map.border()));
    }
}

Rgb RectifiedMap::lookup(Vec2 p) const {
  const auto cell = [&](double c) {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(c * n_), 0, n_ - 1));
  };
  return Rgb(texels_[cell(p.y) * static_cast<std::size_t>(n_) + cell(p.x)]);
}

MapIlluminance RectifiedMap::illuminance(const Rgb& radiance) const {
  MapIlluminance sum;
  const RectifiedCells cells(n_);
  StopPoll poll;
  for (int j = 0; j < n_; ++j) {
    const std::vector<double> lx = cells.row(j);
    MapIlluminance row;
    for (int i = 0; i < n_; ++i, poll()) {
      const Vec2 middle{(i + 0.5) / n_, (j + 0.5) / n_};
      const Rgb l = lookup(middle) * radiance;
      row.lx += l * lx[static_cast<std::size_t>(i)];
      row.without_cosine += l * (sr_per_square(rectified_from_square(middle)) / n_ / n_);
    }
    sum.lx += row.lx;
    sum.without_cosine += row.without_cosine;
  }
  return sum;
}

}  // namespace lucerna

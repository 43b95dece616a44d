#include "server/rays/coherent_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

namespace lucerna {
namespace {

/// Fewer rays are not worth sorting.
constexpr std::size_t kLeastRays = 512;
/// Random points are a third of the box apart along each axis.  Rays whose neighbours are nearer
/// than this sum are in order.
constexpr double kNear = 0.25;
constexpr int kMostBits = 6;  ///< of each coordinate in a key
constexpr std::size_t kRaysPerCell = 4;

/// Bit b of a cell's number goes to bit 3 b.
constexpr std::array<std::uint32_t, 1U << kMostBits> kSpread = [] {
  std::array<std::uint32_t, 1U << kMostBits> spread{};
  for (std::uint32_t cell = 0; cell < spread.size(); ++cell)
    for (int b = 0; b < kMostBits; ++b) spread[cell] |= (cell >> b & 1U) << (3 * b);
  return spread;
}();

/// The points' box, divided into cells.
class Cells {
 public:
  /// About one cell for kRaysPerCell points.
  explicit Cells(std::span<const Vec3f> points)
      : bits_(std::clamp(static_cast<int>(std::bit_width(points.size() / kRaysPerCell)) / 3, 1,
                         kMostBits)),
        across_(static_cast<float>(1U << bits_)) {
    Vec3f upper = lower_ * -1.0F;
    for (const Vec3f& p : points) {
      if (!is_finite(p)) continue;
      lower_ = {std::min(lower_.x, p.x), std::min(lower_.y, p.y), std::min(lower_.z, p.z)};
      upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
    const auto scale = [this](float extent) {
      const float per_m = across_ / extent;
      return extent > 0 && std::isfinite(per_m) ? per_m : 0;
    };
    per_m_ = {scale(upper.x - lower_.x), scale(upper.y - lower_.y), scale(upper.z - lower_.z)};
  }

  float across() const { return across_; }
  std::size_t count() const { return std::size_t{1} << (3 * bits_); }
  /// In [0, across()] along each axis; any number for points that are not finite.
  Vec3f place(const Vec3f& p) const {
    const Vec3f d = p - lower_;
    return {d.x * per_m_.x, d.y * per_m_.y, d.z * per_m_.z};
  }
  /// The number of the point's cell: interleaved bits of its coordinates.
  std::uint32_t cell(const Vec3f& p) const {
    const Vec3f at = place(p);
    return spread(at.x) | spread(at.y) << 1U | spread(at.z) << 2U;
  }

 private:
  std::uint32_t spread(float at) const {
    return at >= 0 ? kSpread[static_cast<std::size_t>(std::min(at, across_ - 1))] : 0;  // 0 for NaN
  }

  int bits_;
  float across_;
  Vec3f lower_{INFINITY, INFINITY, INFINITY}, per_m_;
};

/// The mean distance of neighbours: the sum over the axes, in units of the box.
double mean_step(std::span<const Vec3f> points, const Cells& cells) {
  constexpr std::size_t kStride = 16;
  double sum = 0, pairs = 0;
  for (std::size_t i = 1; i < points.size(); i += kStride, ++pairs) {
    const Vec3f d = cells.place(points[i]) - cells.place(points[i - 1]);
    const float step = (std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z)) / cells.across();
    sum += std::isfinite(step) ? step : 0;
  }
  return sum / pairs;
}

}  // namespace

std::vector<std::uint32_t> coherent_order(std::span<const Vec3f> middles) {
  const std::size_t n = middles.size();
  if (n < kLeastRays) return {};
  const Cells cells(middles);
  if (mean_step(middles, cells) < kNear) return {};
  // Counts the rays of each cell, and then puts each where those of earlier cells end.
  std::vector<std::uint32_t> cell_of(n), next(cells.count() + 1), order(n);
  for (std::size_t i = 0; i < n; ++i) ++next[1 + (cell_of[i] = cells.cell(middles[i]))];
  for (std::size_t c = 1; c < next.size(); ++c) next[c] += next[c - 1];
  for (std::size_t i = 0; i < n; ++i) order[next[cell_of[i]]++] = static_cast<std::uint32_t>(i);
  return order;
}

}  // namespace lucerna

#include "lights/pictures/image_distribution.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

struct Chosen {
  int index;
  double share;  ///< position within the chosen interval, in [0, 1]: the rest of u
};

/// The index of the interval between ascending `sums` (n + 1 of them, the first 0, the last
/// positive) that contains u times the last.  Never returns an interval without length.
Chosen choose(const double* sums, int n, double u) {
  const double target = u * sums[n];
  const auto after = static_cast<int>(std::upper_bound(sums, sums + n + 1, target) - sums);
  int i = std::clamp(after - 1, 0, n - 1);
  // Happens only at u = 1, or if the product is rounded up to the last sum.
  while (i > 0 && !(sums[i + 1] > sums[i])) --i;
  return {i, std::clamp((target - sums[i]) / (sums[i + 1] - sums[i]), 0.0, 1.0)};
}

/// The fraction x of the way from weight a to weight b, with density proportional to a (1 - x) + b
/// x.  This form does not cancel.  An end of weight 0 is never returned, even for u = 0 and 1, so
/// every sample has a density.  [Pharr23, 2.3.2]
double linear_share(double a, double b, double u) {
  if (a == b) return u;
  u = std::clamp(u, 0x1p-80, 1 - 0x1p-53);
  const double x = u * (a + b) / (a + std::sqrt(a * a * (1 - u) + b * b * u));
  return std::clamp(x, 0.0, 1.0);
}

double mix(double a, double b, double share) { return a * (1 - share) + b * share; }

}  // namespace

std::vector<double> luminances(const Image& image, double subtract) {
  std::vector<double> weights;
  weights.reserve(image.texels().size());
  StopPoll poll;
  for (const Rgbf& texel : image.texels())
    poll(), weights.push_back(std::max(0.0, luminance(Rgb(texel)) - subtract));
  return weights;
}

ImageDistribution::Span ImageDistribution::span(int cell, int texels) const {
  const double n = texels;
  if (nearest()) return {cell / n, (cell + 1) / n, 0, 1};
  const bool first = cell == 0;
  const bool last = cell == texels;
  return {first ? 0 : (cell - 0.5) / n, last ? 1 : (cell + 0.5) / n, first ? 0.5 : 0.0,
          last ? 0.5 : 1.0};
}

ImageDistribution::Corners ImageDistribution::corners(int column, int row) const {
  if (nearest()) {
    const double w = weight(column, row);
    return {{{w, w}, {w, w}}};
  }
  Corners c{};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const TexelIndex t = at_border(border_, column - 1 + i, row - 1 + j, width_, height_);
      c.w[j][i] = weight(t.x, t.y);
    }
  // A part of a bilinear patch is bilinear, with the weights at its own corners.
  const Span x = span(column, width_);
  const Span y = span(row, height_);
  Corners part{};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double sx = i == 0 ? x.share_begin : x.share_end;
      part.w[j][i] = mix(mix(c.w[0][0], c.w[0][1], sx), mix(c.w[1][0], c.w[1][1], sx),
                         j == 0 ? y.share_begin : y.share_end);
    }
  return part;
}

ImageDistribution::ImageDistribution(int width, int height, std::vector<double> weights,
                                     ImageFilter filter, ImageBorder border,
                                     std::vector<double> row_measures)
    : width_(width),
      height_(height),
      filter_(filter),
      border_(border),
      across_(filter == ImageFilter::kNearest ? width : width + 1),
      down_(filter == ImageFilter::kNearest ? height : height + 1),
      weights_(std::move(weights)),
      row_densities_(static_cast<std::size_t>(down_), 1.0),
      rows_{0} {
  columns_.reserve(static_cast<std::size_t>(across_ + 1) * static_cast<std::size_t>(down_));
  rows_.reserve(static_cast<std::size_t>(down_) + 1);
  StopPoll poll;
  for (int row = 0; row < down_; ++row) {
    const Span y = span(row, height_);
    const auto r = static_cast<std::size_t>(row);
    if (!row_measures.empty()) row_densities_[r] = row_measures[r] / (y.end - y.begin);
    double sum = 0;
    columns_.push_back(0);
    for (int column = 0; column < across_; ++column, poll()) {
      const Span x = span(column, width_);
      columns_.push_back(sum += corners(column, row).mean() * (x.end - x.begin));
    }
    rows_.push_back(rows_.back() + sum * row_densities_[r] * (y.end - y.begin));
  }
}

ImageDistribution::Sample ImageDistribution::sample(Vec2 u) const {
  if (!(integral() > 0)) return {{u.x, u.y}, 0};
  const Chosen row = choose(rows_.data(), down_, u.y);
  const Chosen column = choose(columns(row.index), across_, u.x);
  const Corners c = corners(column.index, row.index);
  double sy = row.share, sx = column.share;
  if (!nearest()) {
    sy = linear_share(c.w[0][0] + c.w[0][1], c.w[1][0] + c.w[1][1], row.share);
    sx = linear_share(mix(c.w[0][0], c.w[1][0], sy), mix(c.w[0][1], c.w[1][1], sy), column.share);
  } else {
    // The edges belong to the neighbours, so keep rounding away from them.
    sx = std::clamp(sx, 0x1p-30, 1 - 0x1p-30);
    sy = std::clamp(sy, 0x1p-30, 1 - 0x1p-30);
  }
  const Span x = span(column.index, width_);
  const Span y = span(row.index, height_);
  const double w = mix(mix(c.w[0][0], c.w[0][1], sx), mix(c.w[1][0], c.w[1][1], sx), sy);
  return {{mix(x.begin, x.end, sx), mix(y.begin, y.end, sy)},
          w * row_densities_[static_cast<std::size_t>(row.index)] / integral()};
}

double ImageDistribution::pdf(Vec2 position) const {
  if (!(integral() > 0)) return 0;
  if (nearest()) {
    const auto index = [](double c, int n) {
      return std::clamp(static_cast<int>(c * n), 0, n - 1);
    };
    const int y = index(position.y, height_);
    return weight(index(position.x, width_), y) * row_densities_[static_cast<std::size_t>(y)] /
           integral();
  }
  const BetweenCentres x = between_centres(position.x, width_);
  const BetweenCentres y = between_centres(position.y, height_);
  const auto corner = [&](int i, int j) {
    const TexelIndex t = at_border(border_, x.first + i, y.first + j, width_, height_);
    return weight(t.x, t.y);
  };
  return mix(mix(corner(0, 0), corner(1, 0), x.share), mix(corner(0, 1), corner(1, 1), x.share),
             y.share) *
         row_densities_[static_cast<std::size_t>(y.first + 1)] / integral();
}

std::size_t ImageDistribution::bytes() const {
  return sizeof(*this) + (weights_.capacity() + row_densities_.capacity() + columns_.capacity() +
                          rows_.capacity()) *
                             sizeof(double);
}

}  // namespace lucerna

#include "lights/sampling/windowed_distribution.h"

#include <algorithm>
#include <cmath>

#include "lights/maths/stop_poll.h"

namespace lucerna {
namespace {

/// The integer of the largest weight.  Sums over 2^22 such cells stay below 2^63.
constexpr double kLargest = 0x1p40;

/// The least `i` of [first, last] with `cumulative(i) > target`, or `last`.
template <typename F>
int choose(int first, int last, double target, F&& cumulative) {
  while (first < last) {
    const int middle = first + (last - first) / 2;
    if (cumulative(middle) > target)
      last = middle;
    else
      first = middle + 1;
  }
  return first;
}

}  // namespace

WindowedDistribution::WindowedDistribution(int n, const std::vector<double>& weights)
    : n_(n), sums_(static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 1)) {
  const double largest = *std::max_element(weights.begin(), weights.end());
  const auto at = [&](int x, int y) -> std::uint64_t& {
    return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(n_ + 1) +
                 static_cast<std::size_t>(x)];
  };
  StopPoll poll;
  for (int y = 0; y < n; ++y) {
    std::uint64_t row = 0;
    for (int x = 0; x < n; ++x, poll()) {
      const double weight = weights[static_cast<std::size_t>(y) * static_cast<std::size_t>(n) +
                                    static_cast<std::size_t>(x)];
      // Divided first: the product could overflow.
      const double share = largest > 0 ? weight / largest : 0;
      row += 1 + static_cast<std::uint64_t>(share * kLargest);
      at(x + 1, y + 1) = at(x + 1, y) + row;
    }
  }
}

WindowedDistribution::Span WindowedDistribution::span(double begin, double extent) const {
  const double a = std::clamp(begin * n_, 0.0, double(n_));
  const double b = std::clamp(a + extent * n_, a, double(n_));
  const int first = std::min(static_cast<int>(a), n_ - 1);
  const int last = std::min(static_cast<int>(b), n_ - 1);
  const double length = extent * n_;
  if (first == last) return {first, last, length, 0};
  // All parts add up to the extent, even if the position of the window has lost digits.
  const double head = std::min(first + 1 - a, length);
  return {first, last, head, std::clamp(length - head - (last - first - 1), 0.0, 1.0)};
}

std::uint64_t WindowedDistribution::block(int x0, int x1, int y0, int y1) const {
  const auto at = [&](int x, int y) {
    return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(n_ + 1) +
                 static_cast<std::size_t>(x)];
  };
  return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
}

// Each term grows with `to` and with y1.  So the sums ascend even after rounding, as the binary
// search requires.
double WindowedDistribution::across(const Span& x, int to, int y0, int y1) const {
  const auto part = [&](int x0, int x1) { return static_cast<double>(block(x0, x1, y0, y1)); };
  double sum = x.head * part(x.first, x.first + 1);
  if (to > x.first) sum += part(x.first + 1, std::min(to + 1, x.last));
  if (to == x.last && x.last > x.first) sum += x.tail * part(x.last, x.last + 1);
  return sum;
}

double WindowedDistribution::down(const Span& x, const Span& y, int to) const {
  double sum = y.head * across(x, x.last, y.first, y.first + 1);
  if (to > y.first) sum += across(x, x.last, y.first + 1, std::min(to + 1, y.last));
  if (to == y.last && y.last > y.first) sum += y.tail * across(x, x.last, y.last, y.last + 1);
  return sum;
}

WindowedDistribution::Sample WindowedDistribution::sample(const Window& window, Vec2 u) const {
  const Span x = span(window.x, window.width);
  const Span y = span(window.y, window.height);
  const double total = down(x, y, y.last);
  Vec2 at;
  if (u.x < kUniformShare || !(total > 0)) {
    const double ux = total > 0 ? u.x / kUniformShare : u.x;
    at = {window.x + ux * window.width, window.y + u.y * window.height};
  } else {
    u.x = (u.x - kUniformShare) / (1 - kUniformShare);
    const auto place = [&](const Span& s, int cell, double begin, double before, double sum,
                           double target) {
      // The edges belong to the neighbours, so keep rounding away from them.
      const double share = std::clamp((target - before) / (sum - before), 0x1p-30, 1 - 0x1p-30);
      const double start = cell == s.first ? begin : cell / double(n_);
      return start + share * s.share_of(cell) / n_;
    };
    const auto rows = [&](int to) { return to < y.first ? 0 : down(x, y, to); };
    const double target_y = u.y * total;
    int row = choose(y.first, y.last, target_y, rows);
    // Skip a last row without extent, which only u = 1 can reach.
    if (row > y.first && !(rows(row) > rows(row - 1))) --row;
    at.y = place(y, row, window.y, rows(row - 1), rows(row), target_y);
    const auto columns = [&](int to) { return to < x.first ? 0 : across(x, to, row, row + 1); };
    const double target_x = u.x * columns(x.last);
    int column = choose(x.first, x.last, target_x, columns);
    if (column > x.first && !(columns(column) > columns(column - 1))) --column;
    at.x = place(x, column, window.x, columns(column - 1), columns(column), target_x);
  }
  return {at, density(window, total, at)};
}

double WindowedDistribution::pdf(const Window& window, Vec2 position) const {
  const Span x = span(window.x, window.width);
  const Span y = span(window.y, window.height);
  return density(window, down(x, y, y.last), position);
}

double WindowedDistribution::density(const Window& window, double total, Vec2 position) const {
  const double uniform = 1 / (window.width * window.height);
  if (!(total > 0)) return uniform;
  const auto cell = [&](double c) { return std::clamp(static_cast<int>(c * n_), 0, n_ - 1); };
  const int x = cell(position.x), y = cell(position.y);
  const double by_weight = static_cast<double>(block(x, x + 1, y, y + 1)) / total * n_ * n_;
  return (1 - kUniformShare) * by_weight + kUniformShare * uniform;
}

}  // namespace lucerna

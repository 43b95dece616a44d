// Adaptive quadrature over the unit square.
#pragma once

#include <algorithm>
#include <cmath>
#include <queue>

#include "tests/oracle/oracle_gauss.h"
#include "tests/oracle/oracle_truth.h"

namespace lucerna::oracle {

/// Simpson's rule.  Unlike Gauss's it looks at the edges of a cell, where light may begin.
inline constexpr Rule kSimpson{3, {0, 0.5L, 1}, {1 / 6.0L, 4 / 6.0L, 1 / 6.0L}};

/// The integral of f(s, t) over the unit square: divides the cell with the largest error again,
/// until the error is below `enough` or below `share` of the sum, or there are `most` cells.
template <typename F>
Amount integral(const F& f, int across, Real enough, Real share, std::size_t most) {
  struct Square {
    double s, t, size;
    Real value, error;
    bool operator<(const Square& other) const { return error < other.error; }
  };
  const auto square = [&](double s, double t, double h) {
    const auto by = [&](const Rule& rule) {
      Real sum = 0;
      for (std::size_t i = 0; i < static_cast<std::size_t>(rule.points); ++i)
        for (std::size_t j = 0; j < static_cast<std::size_t>(rule.points); ++j)
          sum +=
              rule.weight[i] * rule.weight[j] *
              f(s + h * static_cast<double>(rule.at[i]), t + h * static_cast<double>(rule.at[j]));
      return sum * h * h;
    };
    const Real value = by(kFour);
    // Where light ends within a cell, two rules may agree by chance.
    return Square{s, t, h, value,
                  std::max(std::fabs(value - by(kSimpson)), std::fabs(value - by(kThree)))};
  };
  std::priority_queue<Square> open;
  Real value = 0, error = 0;
  const auto put = [&](const Square& q) {
    value += q.value;
    error += q.error;
    open.push(q);
  };
  const double h = 1.0 / across;
  for (int i = 0; i < across; ++i)
    for (int j = 0; j < across; ++j) put(square(i * h, j * h, h));
  while (error > std::max(enough, share * value) && open.size() < most) {
    const Square q = open.top();
    open.pop();
    value -= q.value;
    error -= q.error;
    const double half = q.size / 2;
    for (const double s : {q.s, q.s + half})
      for (const double t : {q.t, q.t + half}) put(square(s, t, half));
  }
  return {value, std::max(error, Real{0})};
}

}  // namespace lucerna::oracle

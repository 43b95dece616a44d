// Quantiles of numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace lucerna {

/// The nearest-rank quantile: the smallest value such that at least the share `q` of all values is
/// not larger.  `q` is in [0, 1].  0 without values.
template <typename T>
T quantile(std::vector<T> values, double q) {
  if (values.empty()) return T{};
  const auto n = static_cast<double>(values.size());
  // 0.99 * 100 is a little more than 99 in double precision, which must not become rank 100.
  const double rank = std::ceil(q * n * (1 - 1e-12));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::clamp(rank, 1.0, n)) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

template <typename T>
T median(std::vector<T> values) {
  return quantile(std::move(values), 0.5);
}

}  // namespace lucerna

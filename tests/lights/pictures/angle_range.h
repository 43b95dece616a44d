// Angles in equal steps, for tests of photometric data.
#pragma once

#include <vector>

namespace lucerna::testing {

/// The angles from `first` to `last`, which is one of them if it is a multiple of `step` away.
inline std::vector<double> range(double first, double last, double step) {
  std::vector<double> result;
  for (int i = 0; first + i * step <= last + 1e-9; ++i) result.push_back(first + i * step);
  return result;
}

}  // namespace lucerna::testing

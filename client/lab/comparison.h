// Compares numbers row by row.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/lab/finding.h"
#include "client/lab/variation.h"
#include "client/lab/verify_records.h"

namespace lucerna::verify {

/// The smallest and the largest number that rounding of the input may explain.
struct Range {
  double lower = 0, upper = 0;
};

/// The relative error of a number: 0 inside of the range, infinite if only one of both is 0.
double relative_error(double theirs, const Range& ours);

/// Calls `numbers` with directions that rounding by `angle_rad` may have moved, and returns the
/// ranges.  NaN counts in no range.
std::vector<Range> ranges_of(
    const std::vector<Double3>& directions, double angle_rad,
    const std::function<std::vector<double>(const std::vector<Double3>&)>& numbers);

/// Compares numbers, and fills in the rows, errors, place and verdict of `finding`.  `ours` may
/// have NaN for rows that are left out.  `rounded` returns the ranges of the rows that differ from
/// `ours`: the numbers at slightly other directions or places.
void compare(const std::vector<double>& theirs, const std::vector<double>& ours,
             const std::function<std::vector<Range>(const std::vector<std::size_t>&)>& rounded,
             const std::function<std::string(std::size_t)>& place, const Strictness& strictness,
             Finding* finding);

/// At most `most` rows of `n`, evenly spread.
std::vector<std::size_t> some_rows(std::size_t n, std::size_t most);

/// The entries of these rows; empty if `all` is.
template <class T>
std::vector<T> at_rows(const std::vector<T>& all, const std::vector<std::size_t>& rows) {
  std::vector<T> result;
  if (all.empty()) return result;
  for (const std::size_t row : rows) result.push_back(all[row]);
  return result;
}

/// "x y z" with up to four digits.
std::string text(const Double3& v);

}  // namespace lucerna::verify

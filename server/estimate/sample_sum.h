// Sums of many samples without visible rounding errors.
#pragma once

#include <cmath>

#include "lights/maths/rgb.h"

namespace lucerna {

/// A sum with the accuracy of twice the digits of a double.  For n non-negative values the
/// relative error is 1e-16 + (1e-16 n)^2: 1e-14 for 2^30 values.  The error of plain doubles is
/// up to 1e-16 n.  The rounding error of each addition is summed separately.  [Ogita05,
/// algorithm 4.4]
class CompensatedSum {
 public:
  void add(double value) {
    const double before = sum_;
    sum_ = before + value;
    const double added = sum_ - before;
    lost_ += (before - (sum_ - added)) + (value - added);
  }
  /// The sum; infinite if the values sum up to infinity.
  double value() const {
    // `lost_` is NaN if the sum is infinite.
    return std::isfinite(sum_) ? sum_ + lost_ : sum_;
  }

 private:
  double sum_ = 0, lost_ = 0;
};

/// A CompensatedSum for each channel.
class SampleSum {
 public:
  void add(const Rgb& value) {
    r_.add(value.r);
    g_.add(value.g);
    b_.add(value.b);
  }
  Rgb value() const { return {r_.value(), g_.value(), b_.value()}; }

 private:
  CompensatedSum r_, g_, b_;
};

}  // namespace lucerna

// Sums of so many samples that the rounding of each addition would show.
#pragma once

#include <cmath>

#include "lights/spectra/rgb.h"

namespace lucerna {

/// A sum as if it had been added up in twice the digits of a double: of n values that are not
/// negative it is off by 1e-16 and (1e-16 n)^2 of itself, 1e-14 for 2^30 of them, where plain
/// doubles are off by up to 1e-16 n.  What each addition rounds away is itself added up.
/// [Ogita05, algorithm 4.4]
class CompensatedSum {
 public:
  void add(double value) {
    const double before = sum_;
    sum_ = before + value;
    const double added = sum_ - before;
    lost_ += (before - (sum_ - added)) + (value - added);
  }
  /// Infinite where that is what the values sum up to.
  double value() const {
    // Once the sum is infinite, what is lost is no number.
    return std::isfinite(sum_) ? sum_ + lost_ : sum_;
  }

 private:
  double sum_ = 0, lost_ = 0;
};

/// The same of RGB values.
class SampleSum {
 public:
  void add(const Rgb<double>& value) {
    r_.add(value.r);
    g_.add(value.g);
    b_.add(value.b);
  }
  Rgb<double> value() const { return {r_.value(), g_.value(), b_.value()}; }

 private:
  CompensatedSum r_, g_, b_;
};

}  // namespace lucerna

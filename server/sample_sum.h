// Sums of so many samples that the rounding of each addition would show.
#pragma once

#include <cmath>

#include "lights/rgb.h"

namespace lucerna {

/// The sum of RGB values as if it had been added up in twice the digits of a double: of n values
/// that are not negative it is off by 1e-16 and (1e-16 n)^2 of itself, 1e-14 for 2^30 of them,
/// where plain doubles are off by up to 1e-16 n.  What each addition rounds away is itself added
/// up.  [Ogita05, algorithm 4.4]
class SampleSum {
 public:
  void add(const Rgb<double>& value) {
    add(value.r, sum_.r, lost_.r);
    add(value.g, sum_.g, lost_.g);
    add(value.b, sum_.b, lost_.b);
  }
  /// Infinite where that is what the values sum up to.
  Rgb<double> value() const {
    return {value(sum_.r, lost_.r), value(sum_.g, lost_.g), value(sum_.b, lost_.b)};
  }

 private:
  static void add(double value, double& sum, double& lost) {
    const double before = sum;
    sum = before + value;
    const double added = sum - before;
    lost += (before - (sum - added)) + (value - added);
  }
  // Once the sum is infinite, what is lost is no number.
  static double value(double sum, double lost) { return std::isfinite(sum) ? sum + lost : sum; }

  Rgb<double> sum_, lost_;
};

}  // namespace lucerna

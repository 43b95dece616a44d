// Estimates of irradiance in the arrays of an answer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "server/estimate/queries/irradiance.h"

namespace lucerna::rpc {

/// A bound as a float.  One that does not fit, or whose squares overflowed a double, becomes the
/// largest float.
inline float held_as_float(double v) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  return v < kLargest ? static_cast<float>(v) : kLargest;
}

/// The arrays of estimates in a response.  Null: not requested, or unknown from a single sample.
struct EstimateArrays {
  float* rgb;
  float* illuminance;
  float* standard_error;
  float *lower, *upper;
  float* zero_bound;

  /// False if a number does not fit a float; nothing is written then.
  bool put(std::size_t i, const IrradianceEstimate& e) const {
    const Rgb<float> value(e.irradiance_lx);
    const auto lux = static_cast<float>(luminance(e.irradiance_lx));
    const auto error = static_cast<float>(e.illuminance_error_lx);
    if (!is_finite(value) || !std::isfinite(lux)) return false;
    if (standard_error != nullptr && !std::isfinite(error)) return false;
    if (rgb != nullptr) {
      rgb[3 * i] = value.r;
      rgb[3 * i + 1] = value.g;
      rgb[3 * i + 2] = value.b;
    }
    illuminance[i] = lux;
    if (standard_error != nullptr) {
      standard_error[i] = error;
      lower[i] = e.illuminance_lx.lower > 0 ? held_as_float(e.illuminance_lx.lower) : 0;
      upper[i] = held_as_float(e.illuminance_lx.upper);
    }
    if (zero_bound != nullptr) zero_bound[i] = held_as_float(e.zero_bound_lx);
    return true;
  }

  void clear(std::size_t i) const {
    if (rgb != nullptr) std::fill_n(rgb + 3 * i, 3, 0.0F);
    for (float* const array : {illuminance, standard_error, lower, upper, zero_bound}) {
      if (array != nullptr) array[i] = 0;
    }
  }
};

}  // namespace lucerna::rpc

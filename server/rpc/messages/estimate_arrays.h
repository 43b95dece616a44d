// Estimates of irradiance in the arrays of an answer.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "server/estimate/spectral_values.h"
#include "server/queries/receiver_irradiance.h"
#include "server/rpc/messages/checks.h"

namespace lucerna::rpc {

/// A bound as a float.  One that does not fit, or whose squares overflowed a double, becomes the
/// largest float.
inline float held_as_float(double v) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  return v < kLargest ? static_cast<float>(v) : kLargest;
}

/// The arrays of estimates in a response.  Null: not requested, or unknown from a single sample.
struct EstimateArrays {
  float* rgb = nullptr;
  float* illuminance = nullptr;
  float* standard_error = nullptr;
  float *lower = nullptr, *upper = nullptr;
  float* zero_bound = nullptr;

  /// False if a number does not fit a float; nothing is written then.
  bool put(std::size_t i, const IrradianceEstimate& e) const {
    const Rgbf value(e.irradiance_lx);
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

/// The arrays of `to` for n estimates, without colours and bounds of zeros.
template <typename Message>
EstimateArrays estimate_arrays(std::size_t n, bool has_errors, Message* to) {
  EstimateArrays arrays{.illuminance = fill(to->mutable_illuminance_lx(), n)};
  if (!has_errors) return arrays;
  arrays.standard_error = fill(to->mutable_standard_error_lx(), n);
  arrays.lower = fill(to->mutable_lower_lx(), n);
  arrays.upper = fill(to->mutable_upper_lx(), n);
  return arrays;
}

/// The arrays of estimates at wavelengths.
struct SpectralArrays {
  std::size_t wavelengths;
  float* values;
  float* errors;  ///< null: unknown from a single sample

  /// Writes estimate `k` as item `i`.  False if a number does not fit a float.
  bool put(std::size_t i, const std::vector<double>& all_values,
           const std::vector<double>& all_errors, std::size_t k) const {
    const auto store = [&](const std::vector<double>& from, float* to) {
      return to == nullptr ||
             store_spectral({from.data() + k * wavelengths, wavelengths}, to + i * wavelengths);
    };
    return store(all_values, values) && store(all_errors, errors);
  }
  void clear(std::size_t i) const {
    for (float* const array : {values, errors})
      if (array != nullptr) std::fill_n(array + i * wavelengths, wavelengths, 0.0F);
  }
};

}  // namespace lucerna::rpc

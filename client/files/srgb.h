// The transfer function of sRGB.
#pragma once

#include <cmath>

namespace lucerna {

/// The sRGB code in [0, 1] of a linear value in [0, 1], without rounding.  [IEC 61966-2-1]
inline double srgb_encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// The inverse of srgb_encoded.
inline double srgb_decoded(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

}  // namespace lucerna

// Checks of light levels that the `create` functions of lights share.
#pragma once

#include <absl/status/status.h>
#include <fmt/format.h>

#include <limits>
#include <string_view>

#include "lights/spectra/rgb.h"

namespace lucerna {

/// OK where each channel lies in [0, the largest `Real`].
template <std::floating_point Real>
absl::Status check_light_value(std::string_view field, const Rgb<double>& value,
                               std::string_view unit) {
  constexpr double kLargest = std::numeric_limits<Real>::max();
  const auto good = [](double c) { return c >= 0 && c <= kLargest; };
  if (good(value.r) && good(value.g) && good(value.b)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} = ({}, {}, {}) {}, allowed: each channel finite, from 0 to {:.3g}", field,
                  value.r, value.g, value.b, unit, kLargest));
}

}  // namespace lucerna

// Checks of light levels that the `create` functions of lights share.
#pragma once

#include <absl/status/status.h>
#include <fmt/format.h>

#include <limits>
#include <string_view>

#include "lights/maths/rgb.h"

namespace lucerna {

/// The largest value that answers can hold, whose values are floats.
inline constexpr double kMostInAnswers = std::numeric_limits<float>::max();

/// OK where each channel lies in [0, most].
inline absl::Status check_light_value(std::string_view field, const Rgb& value,
                                      std::string_view unit,
                                      double most = std::numeric_limits<double>::max()) {
  const auto good = [most](double c) { return c >= 0 && c <= most; };
  if (good(value.r) && good(value.g) && good(value.b)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} = ({}, {}, {}) {}, allowed: each channel finite, from 0 to {:.3g}", field,
                  value.r, value.g, value.b, unit, most));
}

}  // namespace lucerna

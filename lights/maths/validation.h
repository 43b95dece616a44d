// Checks that the `create` functions of lights share.  A message has the field, its value and the
// allowed range.
#pragma once

#include <absl/status/status.h>
#include <fmt/format.h>

#include <limits>
#include <string_view>

#include "lights/maths/vec.h"

namespace lucerna {

/// OK where `position_m - origin_m` is finite and each coordinate is at most `most_m`.
inline absl::Status check_position(std::string_view field, const Vec3& position_m,
                                   const Vec3& origin_m,
                                   double most_m = std::numeric_limits<double>::max()) {
  const Vec3 offset_m = position_m - origin_m;
  if (is_finite(offset_m) && max_abs(offset_m) <= most_m) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} = ({}, {}, {}) m, allowed: finite, within {:.3g} m of the scene's origin",
                  field, position_m.x, position_m.y, position_m.z, most_m));
}

/// OK where `v` is finite and not zero.
inline absl::Status check_direction(std::string_view field, const Vec3& v) {
  if (is_finite(v) && v != Vec3{}) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} = ({}, {}, {}), allowed: finite, of any length but 0", field, v.x, v.y, v.z));
}

}  // namespace lucerna

// Checks that the `create` functions of lights share.  A message has the field, its value and the
// allowed range.
#pragma once

#include <absl/status/status.h>
#include <fmt/format.h>

#include <limits>
#include <string_view>

#include "lights/maths/vec.h"

namespace lucerna {

/// OK where `position_m - origin_m` is finite as a vector of `Real`.
template <std::floating_point Real>
absl::Status check_position(std::string_view field, const Vec3<double>& position_m,
                            const Vec3<double>& origin_m) {
  if (is_finite(Vec3<Real>(position_m - origin_m))) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format(
      "{} = ({}, {}, {}) m, allowed: finite, within {:.3g} m of the scene's origin", field,
      position_m.x, position_m.y, position_m.z, double{std::numeric_limits<Real>::max()}));
}

/// OK where `v` is finite and not zero.
inline absl::Status check_direction(std::string_view field, const Vec3<double>& v) {
  if (is_finite(v) && v != Vec3<double>{}) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{} = ({}, {}, {}), allowed: finite, of any length but 0", field, v.x, v.y, v.z));
}

}  // namespace lucerna

#include "server/rpc/messages/randomness.h"

#include <fmt/core.h>

#include <cmath>

#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {

absl::Status check_sample_values(const v1::SampleValues& values, const SampleValuesWanted& wanted) {
  const std::size_t n = wanted.samples;
  const auto u_length = static_cast<std::size_t>(values.u_size());
  if (u_length != wanted.per_sample * n) {
    return bad_length(
        "u.u", u_length, wanted.per_sample * n,
        fmt::format("{} for each of {} {}", wanted.per_sample == 2 ? "two" : "four", n, wanted.of));
  }
  const std::size_t u_light = wanted.light_named ? 0 : n;
  const auto u_light_length = static_cast<std::size_t>(values.u_light_size());
  if (u_light_length != u_light) {
    return bad_length("u.u_light", u_light_length, u_light,
                      wanted.light_named ? "since light_id is set"
                                         : fmt::format("one for each of {} {}", n, wanted.of));
  }
  return absl::OkStatus();
}

absl::Status check_u(const v1::SampleValues& values) {
  for (int i = 0; i < values.u_size(); ++i) {
    const float u = values.u(i);
    if ((u < 0 || u > 1) && std::isfinite(u)) {
      return bad_field(fmt::format("u.u[{}]", i), u, "[0, 1]");
    }
  }
  for (int i = 0; i < values.u_light_size(); ++i) {
    const double u = values.u_light(i);
    if ((u < 0 || u >= 1) && std::isfinite(u)) {
      return bad_field(fmt::format("u.u_light[{}]", i), u, "[0, 1)");
    }
  }
  return absl::OkStatus();
}

}  // namespace lucerna::rpc

// What the environment says of how many items there are to be.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace lucerna::testing {

/// The whole number that an environment variable holds, in digits or as 1e6; `otherwise` where it
/// is unset or empty.  INVALID_ARGUMENT for what is none, or is not in [least, 2^53].
absl::StatusOr<std::uint64_t> whole_number_of(const std::string& variable, std::uint64_t least,
                                              std::uint64_t otherwise);

}  // namespace lucerna::testing

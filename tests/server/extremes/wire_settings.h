// Numbers of items from environment variables.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace lucerna::testing {

/// The whole number in an environment variable, in digits or as 1e6; `otherwise` where the variable
/// is unset or empty.  INVALID_ARGUMENT where the text is not a whole number in [least, 2^53].
absl::StatusOr<std::uint64_t> whole_number_of(const std::string& variable, std::uint64_t least,
                                              std::uint64_t otherwise);

}  // namespace lucerna::testing

#include "tests/server/extremes/wire_settings.h"

#include <absl/status/status.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "server/files/photometric_file.h"

namespace lucerna::testing {

absl::StatusOr<std::uint64_t> whole_number_of(const std::string& variable, std::uint64_t least,
                                              std::uint64_t otherwise) {
  const char* text = std::getenv(variable.c_str());
  if (text == nullptr || *text == '\0') return otherwise;
  constexpr double kMost = 0x1p53;
  const std::optional<double> number = parse_number(text);
  if (number && *number >= static_cast<double>(least) && *number <= kMost &&
      *number == std::floor(*number))
    return static_cast<std::uint64_t>(*number);
  return absl::InvalidArgumentError(
      fmt::format("{} = \"{}\", allowed: a whole number from {}, such as 1000000 or 1e6", variable,
                  text, least));
}

}  // namespace lucerna::testing

// Files that an operator writes: settings, tokens, certificates.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <string>

namespace lucerna {

/// Parsed, a settings file takes up to a hundred times its size.
inline constexpr std::size_t kMostTextFileBytes = std::size_t{1} << 20;

/// The bytes of the file.  INVALID_ARGUMENT "cannot be read: why" if there is no such file, if it
/// is a pipe or a device, which might never end, or if it has more than kMostTextFileBytes.
absl::StatusOr<std::string> read_text_file(const std::string& path);

}  // namespace lucerna

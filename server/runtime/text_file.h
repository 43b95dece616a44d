// Files that an operator writes: settings, tokens, certificates.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <string>

namespace lucerna {

/// Parsed, a settings file takes up to a hundred times its size.
inline constexpr std::size_t kMostTextFileBytes = std::size_t{1} << 20;

/// The bytes of the file.  INVALID_ARGUMENT "cannot be read: why" if there is no such file, or if
/// it has more than kMostTextFileBytes.  It reads no more than that, so `path` may also be a
/// device.
absl::StatusOr<std::string> read_text_file(const std::string& path);

}  // namespace lucerna

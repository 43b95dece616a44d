// Checks and errors that all formats of pictures share.  Only for the files of this room.
#pragma once

#include <absl/status/status.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/files/asset_reader.h"

namespace lucerna {

/// The number in `count` bytes from `at`, at most 8; those behind the end of `bytes` are 0.
inline std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t count,
                               std::endian order) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t from = at + (order == std::endian::little ? count - 1 - i : i);
    value = value << 8U | (from < bytes.size() ? static_cast<unsigned char>(bytes[from]) : 0U);
  }
  return value;
}

/// INVALID_ARGUMENT that begins with the name of the file.
absl::Status bad_picture(const AssetContent& content, const std::string& what);

/// The first line of a message of a library, made printable and at most 200 bytes long.  Messages
/// of OpenImageIO name temporary files, quote their content, and may be long.
std::string first_line(const std::string& message);

/// The error for a file that cannot be read as a picture.  `why` is a message of a library, which
/// may be empty.
absl::Status unreadable_picture(const AssetContent& content, const std::string& why);

/// RESOURCE_EXHAUSTED for a picture with more than `max_texels` texels.  A width or height below 1
/// has no texels.
absl::Status check_texels(const AssetContent& content, std::int64_t width, std::int64_t height,
                          std::uint64_t max_texels);

}  // namespace lucerna

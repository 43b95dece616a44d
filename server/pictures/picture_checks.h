// Checks and errors that all formats of pictures share.  Only for the files of this room.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <string>

#include "server/files/asset_reader.h"

namespace lucerna {

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

// Checks the header of an OpenEXR file.  Only for the files of this room.
#pragma once

#include <absl/status/status.h>

#include <cstdint>

#include "server/files/asset_reader.h"

namespace lucerna {

/// Checks that the header has at most 1024 channels and 2048 attributes, of all parts together.
/// Checks that each attribute of the header lies within the file, and that no picture of the file
/// has more than `max_texels` texels.
///
/// OpenImageIO reads headers with OpenEXR's C++ library.  That library allocates the size that an
/// attribute states, and buffers for whole rows, before it compares them with the file.  So a file
/// of 500 bytes could take gigabytes.  OpenEXR's C library checks the sizes first.
///
/// Errors: INVALID_ARGUMENT with the attribute and its size, or the number; RESOURCE_EXHAUSTED for
/// too many texels.
absl::Status check_exr_header(const AssetContent& content, std::uint64_t max_texels);

}  // namespace lucerna

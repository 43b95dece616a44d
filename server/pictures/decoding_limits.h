// Limits on what a picture's library would do for a small file.  Only for the files of this room.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "server/files/asset_reader.h"

namespace lucerna {

/// What the markers of a JPEG file say.  [JPEG, B.1.1]
struct JpegScans {
  std::vector<std::size_t> scans{};  ///< places of their markers
  std::uint64_t texels = 1;
  bool is_progressive = false;

  /// Whether libjpeg keeps all coefficients until the last scan.
  bool keeps_coefficients() const { return is_progressive || scans.size() > 1; }
};
JpegScans jpeg_scans(std::string_view bytes);

/// libjpeg visits every block of a picture for each scan, although a scan of 12 bytes may change
/// none, and can be stopped only between scans.  INVALID_ARGUMENT for too many scans.
absl::Status check_jpeg_scans(const AssetContent& content);

/// libpng unpacks each packed text to up to 8 MB and keeps it.  INVALID_ARGUMENT for too many.
absl::Status check_png_texts(const AssetContent& content);

}  // namespace lucerna

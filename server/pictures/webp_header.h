// The header of WebP files.  Only for the files of this room.
#pragma once

#include <cstdint>
#include <string_view>

namespace lucerna {

struct WebpSize {
  std::int64_t width = 0, height = 0;
};

/// The size that a WebP file states, of its first frame or of the canvas of all.  0 if it states
/// none: then the library does not decode it.  [RFC9649]
WebpSize webp_size(std::string_view bytes);

/// That of TIFF, from the EXIF of the file; 1 if there is none.
int webp_orientation(std::string_view bytes);

}  // namespace lucerna

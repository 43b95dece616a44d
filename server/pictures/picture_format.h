// The formats of pictures that this room reads.  Only for the files of this room.
#pragma once

#include <cstdint>

#include "server/files/asset_reader.h"

namespace lucerna {

/// OpenImageIO decodes those of the first line, and this room the others.
///
/// OpenImageIO reads about twenty more formats.  A server reads files of strangers, so it opens
/// only what scenes need.  The readers of OpenImageIO 2.4 for TGA and BMP read and write outside of
/// their arrays for some files (CVE-2026-43996, CVE-2022-38143); that for Radiance ignores the
/// lines of the header that scale and colour a picture; it has none for QOI.
enum class PictureFormat : std::uint8_t {
  kExr,
  kJpeg,
  kPng,
  kPnm,
  kTiff,
  kWebp,  //
  kBmp,
  kQoi,
  kRadiance,
  kTga,
  kUnknown,
};

/// By the first bytes of the file.  A TGA file has its mark at the end, and old ones have none:
/// then the name or a plausible header counts.
PictureFormat format_of(const AssetContent& content);

/// "TGA", for messages.
const char* name_of(PictureFormat format);
/// "openexr", for OpenImageIO; null for formats that this room decodes.
const char* library_name(PictureFormat format);
/// All of them, for messages.
inline constexpr const char* kKnownFormats =
    "OpenEXR, Radiance, PFM, PPM, PGM, PBM, PNG, TIFF, JPEG, TGA, BMP, QOI, WebP";

}  // namespace lucerna

// The library that decodes pictures.  It depends on OpenImageIO, which loads 250 libraries and
// takes 0.3 s of processor time to start.  So a server loads it with its first picture.
#pragma once

#include <absl/status/statusor.h>

#include "server/files/image_reader.h"

namespace lucerna {

/// What the library offers, by the name kPictureDecoder: see image_reader.h.
struct PictureDecoder {
  absl::StatusOr<DecodedImage> (*image)(const AssetContent&, const ImageOptions&);
  absl::StatusOr<DecodedSurface> (*surface)(const AssetContent&, const ImageOptions&);
  absl::StatusOr<DecodedAlpha> (*alpha)(const AssetContent&, const ImageOptions&);
};
inline constexpr const char* kPictureDecoder = "lucerna_picture_decoder";

}  // namespace lucerna

// Pictures for lights, from the bytes of image files: the one place of the server that knows
// OpenImageIO.
//
// Integer texels are sRGB-coded, floating-point ones linear, both Rec. 709, as pbrt-v4 takes them.
// Alpha is not applied.  Formats: OpenEXR, Radiance .hdr, .pfm, PNG, TIFF, JPEG.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lights/pictures/image.h"
#include "server/assets/asset_reader.h"

namespace lucerna {

/// What a picture says and lights do not use, and what happens instead.
struct ImageRemark {
  std::string what;
  std::string instead;
};

struct DecodedImage {
  std::shared_ptr<const Image> image;
  std::vector<ImageRemark> remarks;
};

/// The largest picture: 16384 x 8192 texels, 1.6 GB in memory.
inline constexpr std::uint64_t kMaxImageTexels = std::uint64_t{1} << 27;

/// The first picture of an image file.  One or two channels are grey (and alpha); of more, those
/// named R, G and B are taken.  Texels below 0 count as 0, with a remark that counts them.
///
/// Errors, which begin with the file's name: INVALID_ARGUMENT for what is no picture of a known
/// format, has no texels, no R, G and B, integers of more than 16 bits, or a texel that is not
/// finite (its place is said); RESOURCE_EXHAUSTED beyond `max_texels`.
absl::StatusOr<DecodedImage> decode_image(const AssetContent& content,
                                          std::uint64_t max_texels = kMaxImageTexels);

}  // namespace lucerna

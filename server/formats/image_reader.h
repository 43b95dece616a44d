// Decodes image files for lights and textures.  Only this file of the server knows OpenImageIO.
//
// Integer texels are sRGB-coded by default and floating-point texels are linear, both with the
// primaries of Rec. 709, as in pbrt-v4.  Alpha is not applied.  Formats: OpenEXR, Radiance .hdr,
// .pfm, PNG, TIFF, JPEG.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lights/pictures/image.h"
#include "server/assets/asset_reader.h"

namespace lucerna {

/// A part of a picture that lights do not use, and what happens instead.
struct ImageRemark {
  std::string what;
  std::string instead;
  bool is_alpha = false;  ///< about a channel that some formats of scenes define as not used
};

struct DecodedImage {
  std::shared_ptr<const Image> image;
  std::vector<ImageRemark> remarks;
};

/// What the integer texels of a picture mean.  Floating-point texels are linear in any case.
struct Encoding {
  double gamma = 0;  ///< value = code^gamma; 0: sRGB.  1: linear
  bool operator==(const Encoding&) const = default;
  bool operator<(const Encoding& e) const { return gamma < e.gamma; }
};
inline constexpr Encoding kSrgb{0}, kLinear{1};

/// The largest picture: 16384 x 8192 texels, 1.6 GB in memory.
inline constexpr std::uint64_t kMaxImageTexels = std::uint64_t{1} << 27;

/// Decodes the first picture of an image file.  One or two channels are grey (and alpha); of more
/// channels, R, G and B are used.  Texels below 0 count as 0, with a remark that counts them.
///
/// Errors begin with the file's name.  INVALID_ARGUMENT for an unknown format, no texels, no R, G
/// and B, integers of more than 16 bits, or a texel that is not finite (with its position);
/// RESOURCE_EXHAUSTED for more than `max_texels`.
absl::StatusOr<DecodedImage> decode_image(const AssetContent& content,
                                          std::uint64_t max_texels = kMaxImageTexels,
                                          Encoding encoding = kSrgb);

/// The alpha of each texel of the first picture, rows from the top, in [0, 1] for integers.  Empty
/// if the picture has no alpha.  Errors: those of decode_image.
absl::StatusOr<std::vector<float>> decode_alpha(const AssetContent& content,
                                                std::uint64_t max_texels = kMaxImageTexels);

}  // namespace lucerna

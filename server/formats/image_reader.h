// Decodes image files for lights and textures.  Only this room of the server knows OpenImageIO.
//
// Integer texels are sRGB-coded by default and floating-point texels are linear, both with the
// primaries of Rec. 709, as in pbrt-v4.  Alpha is not applied.  Formats: OpenEXR, Radiance .hdr,
// .pfm, PNG, TIFF, JPEG.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "lights/pictures/image.h"
#include "server/assets/asset_reader.h"
#include "server/assets/load_budget.h"

namespace lucerna {

/// A part of a picture that lights do not use, and what happens instead.
struct ImageRemark {
  std::string what;
  std::string instead;
  bool is_alpha = false;  ///< about a channel that some formats of scenes define as not used
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

struct ImageOptions {
  std::uint64_t max_texels = kMaxImageTexels;
  Encoding encoding = kSrgb;
  std::stop_token stop{};
  LoadBudget* budget = nullptr;  ///< null: no limit
};

struct DecodedImage {
  std::shared_ptr<const Image> image;
  std::vector<ImageRemark> remarks;
  LoadBudget::Share share;  ///< of the texels
};

/// Decodes the first picture of an image file.  One or two channels are grey (and alpha); of more
/// channels, R, G and B are used.  Texels below 0 count as 0, with a remark that counts them.
///
/// The size in the header is checked before anything is allocated.  Texels are decoded in bands of
/// rows, and `stop` ends the decoding after a band.
///
/// Errors begin with the file's name, except CANCELLED and refusals of the budget.
/// INVALID_ARGUMENT for an unknown format, no texels, no R, G and B, integers of more than 16 bits,
/// or a texel that is not finite (with its position); RESOURCE_EXHAUSTED for more than `max_texels`
/// or bytes than the budget has.
absl::StatusOr<DecodedImage> decode_image(const AssetContent& content,
                                          const ImageOptions& options = {});

/// A picture as the codes of its texels.  A code is an index into `values`.
struct CodedImage {
  int width = 0, height = 0;
  bool is_grey = false;             ///< one code for each texel; else three: R, G and B
  std::vector<std::uint8_t> codes;  ///< rows from the top
  std::vector<float> values;        ///< 256
};

/// A picture for a surface: `codes` if it has integers of 8 bits, else `image`.
struct DecodedSurface {
  std::optional<CodedImage> codes;
  std::shared_ptr<const Image> image;
  std::vector<ImageRemark> remarks;
  LoadBudget::Share share;  ///< of the texels
};

/// The same as decode_image, in a byte for each code if the picture has integers of 8 bits.
absl::StatusOr<DecodedSurface> decode_surface(const AssetContent& content,
                                              const ImageOptions& options = {});

struct DecodedAlpha {
  int width = 0, height = 0;
  /// Rows from the top, in [0, 1] for integers.  Empty if the picture has no alpha.
  std::vector<float> values;
  LoadBudget::Share share;  ///< of the values
};

/// The alpha of each texel of the first picture.  Errors: those of decode_image.
absl::StatusOr<DecodedAlpha> decode_alpha(const AssetContent& content,
                                          const ImageOptions& options = {});

}  // namespace lucerna

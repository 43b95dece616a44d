// Decodes image files for lights and textures.  Only this room of the server knows OpenImageIO.
//
// Integer texels are sRGB-coded by default and floating-point texels are linear.  Colours become
// those of Rec. 709.  Alpha is not applied.  Formats: OpenEXR, Radiance, PFM, PPM, PGM, PBM, PNG,
// TIFF, JPEG, TGA, BMP, QOI, WebP.  The first bytes of a file decide, and not its name.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "lights/pictures/image.h"
#include "server/files/asset_reader.h"
#include "server/files/load_budget.h"

namespace lucerna {

/// A part of a picture that lights do not use, and what happens instead.
struct ImageRemark {
  std::string what;
  std::string instead;
  bool is_by_gltf = false;  ///< about alpha or a colour space, whose use glTF defines for all files
};

/// What the texels of a picture mean.
struct Encoding {
  enum class Meaning : std::uint8_t {
    kColour,
    kLuminance,  ///< colours in cd/m2, if the file states the luminance of white
    kData,       ///< no colours, such as normals: the primaries in the file have no meaning
  };
  double gamma = 0;  ///< of integers: value = code^gamma; 0: sRGB.  1: linear
  Meaning meaning = Meaning::kColour;
  auto operator<=>(const Encoding&) const = default;
};
inline constexpr Encoding kSrgb{0}, kLinear{1}, kLuminances{0, Encoding::Meaning::kLuminance},
    kData{1, Encoding::Meaning::kData};

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

/// Decodes the first picture of an image file that has colours.  Its R, G and B are used, or those
/// of the first layer that has them, or X, Y and Z; else a single channel besides alpha and depth
/// is grey.  Texels below 0 count as 0, with a remark that counts them.
///
/// The picture is turned and mirrored as the file says.  An OpenEXR picture is that of the display
/// window, black where the file has no texels.  Where an OpenEXR or Radiance file states primaries,
/// its colours are converted to Rec. 709 with the same X, Y and Z.  Colours outside of Rec. 709
/// become colours of the same luminance at its edge, with a remark that counts them.
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
/// Conversions from other primaries keep white, since the texels are reflectances.
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

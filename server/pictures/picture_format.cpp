#include "server/pictures/picture_format.h"

#include <absl/strings/match.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>

namespace lucerna {
namespace {

/// The name for messages, and that of OpenImageIO if it decodes the format.
struct Names {
  const char* shown;
  const char* library = nullptr;
};

const Names& names_of(PictureFormat format) {
  // In the order of PictureFormat.
  static constexpr auto kNames = std::to_array<Names>({{"OpenEXR", "openexr"},
                                                       {"JPEG", "jpeg"},
                                                       {"PNG", "png"},
                                                       {"PFM, PPM, PGM or PBM", "pnm"},
                                                       {"TIFF", "tiff"},
                                                       {"WebP", "webp"},
                                                       {"BMP"},
                                                       {"QOI"},
                                                       {"Radiance"},
                                                       {"TGA"},
                                                       {"unknown"}});
  return kNames[static_cast<std::size_t>(format)];
}

/// Whether the bytes are a header of TGA, in which each field has few values.  [TGA2]
bool has_tga_header(std::string_view bytes) {
  constexpr std::size_t kHeaderBytes = 18;
  if (bytes.size() <= kHeaderBytes) return false;
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  const auto is_one_of = [](int value, std::initializer_list<int> allowed) {
    return std::ranges::find(allowed, value) != allowed.end();
  };
  const bool has_palette = at(1) == 1;
  const bool palette_fits =
      has_palette ? is_one_of(at(7), {15, 16, 24, 32})
                  : at(1) == 0 && bytes.substr(3, 5) == std::string_view("\0\0\0\0\0", 5);
  const bool kind_fits =
      has_palette ? is_one_of(at(2), {1, 2, 3, 9, 10, 11}) : is_one_of(at(2), {2, 3, 10, 11});
  const bool has_texels = (at(12) | at(13)) != 0 && (at(14) | at(15)) != 0;
  return palette_fits && kind_fits && has_texels && is_one_of(at(16), {8, 15, 16, 24, 32}) &&
         (at(17) & 0xc0U) == 0;
}

bool is_tga(const AssetContent& content) {
  constexpr std::string_view kFooter("TRUEVISION-XFILE.\0", 18);  // [TGA2]
  return std::string_view(content.bytes).ends_with(kFooter) ||
         absl::EndsWithIgnoreCase(content.name, ".tga") || has_tga_header(content.bytes);
}

}  // namespace

PictureFormat format_of(const AssetContent& content) {
  using enum PictureFormat;
  const std::string_view bytes = content.bytes;
  struct Start {
    std::string_view bytes;
    PictureFormat format;
  };
  static constexpr auto kStarts = std::to_array<Start>({{"\x76\x2f\x31\x01", kExr},
                                                        {"\xff\xd8\xff", kJpeg},
                                                        {"\x89PNG", kPng},
                                                        {{"II*\0", 4}, kTiff},
                                                        {{"MM\0*", 4}, kTiff},
                                                        {{"II+\0", 4}, kTiff},
                                                        {{"MM\0+", 4}, kTiff},
                                                        {"qoif", kQoi},
                                                        {"#?", kRadiance},
                                                        {"BM", kBmp}});
  for (const Start& start : kStarts)
    if (bytes.starts_with(start.bytes)) return start.format;
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return kWebp;
  if (bytes.size() > 2 && bytes[0] == 'P' &&
      std::string_view("123456Ff").find(bytes[1]) != std::string_view::npos)
    return kPnm;
  return is_tga(content) ? kTga : kUnknown;
}

const char* name_of(PictureFormat format) { return names_of(format).shown; }
const char* library_name(PictureFormat format) { return names_of(format).library; }

}  // namespace lucerna

// Reads the input as a picture.  Its first byte chooses the ending of the file's name.
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include "server/files/image_reader.h"
#include "tests/fuzz/input_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  if (size == 0) return 0;
  // The first bytes decide the format, except for TGA.
  constexpr std::array kEndings{".exr", ".hdr", ".pfm", ".png", ".tif", ".jpg", ".gif", ".tga"};
  constexpr std::uint64_t kMostTexels = 1 << 12;
  const AssetContent content{std::string("picture") + kEndings[data[0] % kEndings.size()],
                             std::string(fuzz::text_of(data + 1, size - 1))};
  const ImageOptions options{.max_texels = kMostTexels};
  static_cast<void>(decode_image(content, options));
  static_cast<void>(decode_surface(content, options));
  static_cast<void>(decode_image(content, {.max_texels = kMostTexels, .encoding = kLuminances}));
  const auto alpha = decode_alpha(content, options);
  if (!alpha.ok()) return 0;
  for (const float value : alpha->values)
    if (!std::isfinite(value)) std::abort();
  return 0;
}

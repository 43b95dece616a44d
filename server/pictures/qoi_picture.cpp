#include "server/pictures/qoi_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

namespace lucerna {
namespace {

constexpr std::size_t kQoiHeaderBytes = 14;

}  // namespace

absl::Status QoiPicture::read_header() {
  if (bytes().size() < kQoiHeaderBytes) return ends_early();
  const std::uint32_t width = number(4, 4, std::endian::big),
                      height = number(8, 4, std::endian::big);
  const std::uint32_t channels = number(12, 1), space = number(13, 1);
  constexpr std::uint32_t kMost = std::numeric_limits<int>::max();
  if (width > kMost || height > kMost || (channels != 3 && channels != 4) || space > 1)
    return absl::InvalidArgumentError(
        fmt::format("{} x {} texels of {} channels in colour space {}, allowed: 3 or 4 channels in "
                    "space 0 or 1",
                    width, height, channels, space));
  m_spec = OIIO::ImageSpec(static_cast<int>(width), static_cast<int>(height),
                           static_cast<int>(channels), OIIO::TypeDesc::UINT8);
  if (space == 1) m_spec.attribute("oiio:ColorSpace", "Linear");
  return absl::OkStatus();
}

absl::Status QoiPicture::decode(std::uint8_t* to) {
  using Texel = std::array<std::uint8_t, 4>;
  std::array<Texel, 64> seen{};
  Texel texel{0, 0, 0, 255};
  const std::size_t channels = m_spec.nchannels;
  std::size_t at = kQoiHeaderBytes;
  const auto add = [&](std::size_t c, std::uint32_t difference) {
    texel[c] = static_cast<std::uint8_t>(texel[c] + difference);
  };
  std::uint64_t left = texels();
  for (std::uint64_t step = 0; left > 0; ++step) {
    if (step % 65536 == 0 && stopped()) return absl::CancelledError();
    if (at >= bytes().size()) return ends_early();
    const std::uint32_t tag = number(at++, 1), low = tag & 63U;
    std::uint64_t run = 1;
    if (tag >= 254) {  // RGB or RGBA
      const std::size_t count = tag == 254 ? 3 : 4;
      if (count > bytes().size() - at) return ends_early();
      for (std::size_t c = 0; c < count; ++c) texel[c] = static_cast<std::uint8_t>(number(at++, 1));
    } else if (tag >= 192) {
      run = low + 1;
    } else if (tag >= 128) {  // differences to green
      if (at >= bytes().size()) return ends_early();
      const std::uint32_t next = number(at++, 1), green = low - 32;
      add(0, green + (next >> 4U) - 8);
      add(1, green);
      add(2, green + (next & 15U) - 8);
    } else if (tag >= 64) {
      for (std::size_t c = 0; c < 3; ++c) add(c, (low >> (4 - 2 * c) & 3U) - 2);
    } else {
      texel = seen[low];
    }
    seen[(texel[0] * 3U + texel[1] * 5U + texel[2] * 7U + texel[3] * 11U) % 64] = texel;
    run = std::min(run, left);
    for (std::uint64_t i = 0; i < run; ++i) to = std::copy_n(texel.begin(), channels, to);
    left -= run;
  }
  return absl::OkStatus();
}

}  // namespace lucerna

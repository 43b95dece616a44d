// TGA files.  [TGA2]  Only for the files of this room.
#pragma once

#include <array>

#include "server/pictures/whole_picture.h"

namespace lucerna {

/// Grey, colours and palettes of 8 to 32 bits, also in runs.  Integers of 8 bits in 1 to 4
/// channels. Colours of 16 bits have five for each channel.
class TgaPicture final : public WholePicture {
 public:
  using WholePicture::WholePicture;

 private:
  absl::Status read_header() override;
  absl::Status decode(std::uint8_t* to) override;
  /// The texel that the value in the file means, with the palette.  Channels: grey, grey and alpha,
  /// RGB or RGBA.
  std::array<std::uint8_t, 4> texel(std::uint32_t value) const;

  bool has_palette_ = false, has_runs_ = false, is_grey_ = false;
  std::size_t value_bytes_ = 0;                            ///< of a texel in the file
  std::size_t first_ = 0, entries_ = 0, entry_bytes_ = 0;  ///< of the palette
  std::size_t palette_at_ = 0, texels_at_ = 0;
};

}  // namespace lucerna

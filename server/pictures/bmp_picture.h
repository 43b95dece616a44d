// BMP files of OS/2 and Windows.  Only for the files of this room.
#pragma once

#include <array>

#include "server/pictures/whole_picture.h"

namespace lucerna {

/// Palettes of 1, 4 and 8 bits, also in runs, and colours of 16, 24 and 32 bits with any masks.
/// Integers of 8 bits in three channels, or four if the header has a mask of alpha.
class BmpPicture final : public WholePicture {
 public:
  using WholePicture::WholePicture;

 private:
  /// The bits of a channel in a texel.
  struct Mask {
    std::uint32_t bits = 0;
    unsigned shift = 0;
    std::uint32_t most = 0;
    std::uint8_t of(std::uint32_t texel) const {
      return static_cast<std::uint8_t>(
          most == 0 ? 0 : (std::uint64_t{(texel & bits) >> shift} * 255 + most / 2) / most);
    }
  };
  absl::Status read_header() override;
  absl::Status read_masks(std::uint32_t header_bytes);
  absl::Status decode(std::uint8_t* to) override;
  absl::Status decode_runs(std::uint8_t* to) const;
  void put_entry(std::uint32_t index, std::uint8_t* to) const;

  std::uint32_t bits_ = 0, compression_ = 0;
  std::size_t palette_at_ = 0, entries_ = 0, entry_bytes_ = 4, texels_at_ = 0;
  std::array<Mask, 4> masks_{};
};

}  // namespace lucerna

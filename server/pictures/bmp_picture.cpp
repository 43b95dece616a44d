#include "server/pictures/bmp_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "proto/common/status_macros.h"

namespace lucerna {
namespace {

constexpr std::size_t kFileHeaderBytes = 14;
constexpr std::uint32_t kCore = 12, kInfo = 40;  // bytes of the headers of OS/2 and of Windows 3
enum : std::uint32_t { kPlain = 0, kRuns8 = 1, kRuns4 = 2, kMasks = 3, kAlphaMasks = 6 };

}  // namespace

absl::Status BmpPicture::read_header() {
  const std::uint32_t header = number(kFileHeaderBytes, 4);
  if ((header != kCore && (header < kInfo || header > 256)) ||
      kFileHeaderBytes + header > bytes().size())
    return absl::InvalidArgumentError(
        fmt::format("a header of {} bytes, allowed: 12 or 40 to 256, within the file", header));
  const bool is_core = header == kCore;
  const auto signed_number = [&](std::size_t at) {
    return static_cast<std::int64_t>(static_cast<std::int32_t>(number(at, 4)));
  };
  const std::int64_t width = is_core ? number(18, 2) : signed_number(18);
  const std::int64_t height = is_core ? number(20, 2) : signed_number(22);
  bits_ = number(is_core ? 24 : 28, 2);
  compression_ = is_core ? kPlain : number(30, 4);
  const bool runs = compression_ == kRuns8 || compression_ == kRuns4;
  const bool has_masks = compression_ == kMasks || compression_ == kAlphaMasks;
  constexpr std::array kSizes{1U, 4U, 8U, 16U, 24U, 32U};
  const bool fits =
      runs        ? bits_ == (compression_ == kRuns8 ? 8U : 4U)
      : has_masks ? bits_ == 16 || bits_ == 32
                  : compression_ == kPlain && std::ranges::find(kSizes, bits_) != kSizes.end();
  // Rows from the bottom have a positive height.  Those with runs have no other.
  if (!fits || width < 1 || height == 0 || std::abs(height) > 0x7fffffff || (runs && height < 0))
    return absl::InvalidArgumentError(
        fmt::format("{} x {} texels of {} bits in compression {}, allowed: 1, 4, 8, 16, 24 or 32 "
                    "bits in compression 0, 1, 2, 3 or 6",
                    width, height, bits_, compression_));
  palette_at_ = kFileHeaderBytes + header;
  if (has_masks && header == kInfo) palette_at_ += compression_ == kMasks ? 12 : 16;
  if (bits_ <= 8) {
    entry_bytes_ = is_core ? 3 : 4;
    const std::uint32_t given = is_core ? 0 : number(46, 4);
    entries_ = given == 0 ? std::size_t{1} << bits_ : std::min<std::size_t>(given, 256);
  }
  texels_at_ = number(10, 4);
  if (palette_at_ + entries_ * entry_bytes_ > bytes().size() || texels_at_ > bytes().size())
    return ends_early();
  LUCERNA_RETURN_IF_ERROR(read_masks(header));
  m_spec = OIIO::ImageSpec(static_cast<int>(width), static_cast<int>(std::abs(height)),
                           masks_[3].bits == 0 ? 3 : 4, OIIO::TypeDesc::UINT8);
  m_spec.attribute("Orientation", height > 0 ? 4 : 1);
  return absl::OkStatus();
}

absl::Status BmpPicture::read_masks(std::uint32_t header_bytes) {
  if (bits_ < 16) return absl::OkStatus();
  std::array<std::uint32_t, 4> masks{0xff0000, 0xff00, 0xff, 0};
  if (bits_ == 16) masks = {0x7c00, 0x3e0, 0x1f, 0};
  if (compression_ == kMasks || compression_ == kAlphaMasks) {
    constexpr std::size_t kMasksAt = kFileHeaderBytes + kInfo;
    constexpr std::uint32_t kWithAlpha = 56;  // the first header with a mask of alpha
    const std::size_t count = compression_ == kAlphaMasks || header_bytes >= kWithAlpha ? 4 : 3;
    for (std::size_t c = 0; c < count; ++c) masks[c] = number(kMasksAt + 4 * c, 4);
  }
  for (std::size_t c = 0; c < masks.size(); ++c) {
    if (masks[c] == 0) continue;
    const auto shift = static_cast<unsigned>(std::countr_zero(masks[c]));
    masks_[c] = {masks[c], shift, masks[c] >> shift};
    if (!std::has_single_bit(std::uint64_t{masks_[c].most} + 1))
      return absl::InvalidArgumentError(
          fmt::format("a mask of {:#x}, allowed: one run of bits", masks[c]));
  }
  return absl::OkStatus();
}

void BmpPicture::put_entry(std::uint32_t index, std::uint8_t* to) const {
  // An index outside of the palette means its last entry.
  const std::size_t entry = std::min<std::size_t>(index, entries_ - 1);
  const std::uint32_t colour = number(palette_at_ + entry * entry_bytes_, 3);
  for (unsigned c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>(colour >> (16 - 8 * c));
}

absl::Status BmpPicture::decode(std::uint8_t* to) {
  if (compression_ == kRuns8 || compression_ == kRuns4) return decode_runs(to);
  const std::size_t channels = m_spec.nchannels;
  // Rows end at multiples of four bytes.
  const std::size_t row_bytes = (width() * bits_ + 31) / 32 * 4;
  for (std::size_t y = 0; y < height(); ++y) {
    if (stopped()) return absl::CancelledError();
    const std::size_t row = texels_at_ + y * row_bytes;
    if (row + (width() * bits_ + 7) / 8 > bytes().size()) return ends_early();
    for (std::size_t x = 0; x < width(); ++x, to += channels) {
      const std::size_t bit = x * bits_;
      if (bits_ <= 8) {
        const std::uint32_t byte = number(row + bit / 8, 1);
        put_entry(byte >> (8 - bits_ - bit % 8) & ((1U << bits_) - 1), to);
        continue;
      }
      const std::uint32_t texel = number(row + bit / 8, bits_ / 8);
      for (std::size_t c = 0; c < channels; ++c) to[c] = masks_[c].of(texel);
    }
  }
  return absl::OkStatus();
}

absl::Status BmpPicture::decode_runs(std::uint8_t* to) const {
  // Texels that no run reaches have the first entry.
  for (std::uint64_t i = 0; i < texels(); ++i) put_entry(0, to + 3 * i);
  std::size_t x = 0, y = 0, at = texels_at_;
  const auto put = [&](std::uint32_t index) {
    if (x < width()) put_entry(index, to + 3 * (y * width() + x));
    ++x;
  };
  // The texel `i` of a pair of half bytes, or of two bytes.
  const auto index = [&](std::uint32_t byte, std::uint32_t i) {
    return compression_ == kRuns8 ? byte : byte >> (i % 2 == 0 ? 4U : 0U) & 15U;
  };
  while (y < height()) {
    if (stopped()) return absl::CancelledError();
    if (at + 2 > bytes().size()) return ends_early();
    const std::uint32_t count = number(at, 1), value = number(at + 1, 1);
    at += 2;
    if (count > 0) {
      for (std::uint32_t i = 0; i < count; ++i) put(index(value, i));
    } else if (value == 0) {  // the end of a row
      x = 0;
      ++y;
    } else if (value == 1) {  // the end of the picture
      break;
    } else if (value == 2) {  // a step
      if (at + 2 > bytes().size()) return ends_early();
      x += number(at, 1);
      y += number(at + 1, 1);
      at += 2;
    } else {  // single texels, up to a multiple of two bytes
      const std::size_t size = compression_ == kRuns8 ? value : (value + 1) / 2;
      if (size > bytes().size() - at) return ends_early();
      for (std::uint32_t i = 0; i < value; ++i)
        put(index(number(at + (compression_ == kRuns8 ? i : i / 2), 1), i));
      at += (size + 1) / 2 * 2;
    }
  }
  return absl::OkStatus();
}

}  // namespace lucerna

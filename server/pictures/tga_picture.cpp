#include "server/pictures/tga_picture.h"

#include <fmt/format.h>

#include <algorithm>

namespace lucerna {
namespace {

constexpr std::size_t kTgaHeaderBytes = 18;

/// Of 5 bits.
std::uint8_t of_five_bits(std::uint32_t value) {
  return static_cast<std::uint8_t>(((value & 31U) * 255 + 15) / 31);
}

bool is_colour_size(std::uint32_t bits) {
  return bits == 15 || bits == 16 || bits == 24 || bits == 32;
}

}  // namespace

absl::Status TgaPicture::read_header() {
  if (bytes().size() < kTgaHeaderBytes) return ends_early();
  const std::uint32_t kind = number(2, 1), bits = number(16, 1), descriptor = number(17, 1);
  has_runs_ = kind >= 8;
  has_palette_ = kind == 1 || kind == 9;
  is_grey_ = kind == 3 || kind == 11;
  if (!has_palette_ && !is_grey_ && kind != 2 && kind != 10)
    return absl::InvalidArgumentError(
        fmt::format("image type {}, allowed: 1, 2, 3, 9, 10, 11", kind));
  if (has_palette_ || is_grey_ ? bits != 8 && bits != 16 : !is_colour_size(bits))
    return absl::InvalidArgumentError(
        fmt::format("{} bits for each texel, allowed: {}", bits,
                    has_palette_ || is_grey_ ? "8, 16" : "15, 16, 24, 32"));
  value_bytes_ = (bits + 7) / 8;
  // A file may have a palette that it does not use.
  const std::uint32_t entry_bits = number(7, 1);
  entry_bytes_ = (entry_bits + 7) / 8;
  entries_ = number(1, 1) == 0 ? 0 : number(5, 2);
  first_ = number(3, 2);
  palette_at_ = kTgaHeaderBytes + number(0, 1);
  texels_at_ = palette_at_ + entries_ * entry_bytes_;
  if (has_palette_ && (entries_ == 0 || !is_colour_size(entry_bits)))
    return absl::InvalidArgumentError(
        fmt::format("a palette of {} entries of {} bits, allowed: at least one of 15, 16, 24 or 32",
                    entries_, entry_bits));
  if (texels_at_ > bytes().size()) return ends_early();
  const std::size_t colour_bits = has_palette_ ? entry_bits : bits;
  // Without bits for alpha, the fourth byte has no meaning.
  const bool has_alpha = is_grey_ ? bits == 16 : colour_bits == 32 && (descriptor & 15U) != 0;
  m_spec = OIIO::ImageSpec(static_cast<int>(number(12, 2)), static_cast<int>(number(14, 2)),
                           (is_grey_ ? 1 : 3) + (has_alpha ? 1 : 0), OIIO::TypeDesc::UINT8);
  // Bit 5: the first row is the top.  Bit 4: the first column is the right one.
  constexpr std::array kOrientations{4, 3, 1, 2};
  m_spec.attribute("Orientation", kOrientations[descriptor >> 4U & 3U]);
  return absl::OkStatus();
}

std::array<std::uint8_t, 4> TgaPicture::texel(std::uint32_t value) const {
  std::size_t size = value_bytes_;
  if (has_palette_) {
    // An index outside of the palette means its nearest entry.
    const std::size_t index =
        std::clamp<std::size_t>(value, first_, first_ + entries_ - 1) - first_;
    value = number(palette_at_ + index * entry_bytes_, entry_bytes_);
    size = entry_bytes_;
  }
  const auto byte = [&](unsigned i) { return static_cast<std::uint8_t>(value >> (8 * i)); };
  if (is_grey_) return {byte(0), byte(1)};
  if (size == 2)
    return {of_five_bits(value >> 10U), of_five_bits(value >> 5U), of_five_bits(value)};
  return {byte(2), byte(1), byte(0), byte(3)};
}

absl::Status TgaPicture::decode(std::uint8_t* to) {
  const std::size_t channels = m_spec.nchannels;
  std::size_t at = texels_at_;
  for (std::uint64_t left = texels(); left > 0;) {
    if (stopped()) return absl::CancelledError();
    std::uint64_t count = left;
    bool is_run = false;
    if (has_runs_) {
      const std::uint32_t head = number(at, 1);
      is_run = head >= 128;
      count = std::min<std::uint64_t>(left, (head & 127U) + 1);
      ++at;
    } else {
      count = std::min<std::uint64_t>(left, width());
    }
    if (at > bytes().size() || (is_run ? 1 : count) * value_bytes_ > bytes().size() - at)
      return ends_early();
    std::array<std::uint8_t, 4> value{};
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i == 0 || !is_run) {
        value = texel(number(at, value_bytes_));
        at += value_bytes_;
      }
      to = std::copy_n(value.begin(), channels, to);
    }
    left -= count;
  }
  return absl::OkStatus();
}

}  // namespace lucerna

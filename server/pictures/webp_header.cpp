#include "server/pictures/webp_header.h"

#include <cstddef>

namespace lucerna {
namespace {

/// `count` bytes from `at`; those behind the end are 0.
std::uint32_t number(std::string_view bytes, std::size_t at, std::size_t count,
                     bool little_endian = true) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t from = at + (little_endian ? count - 1 - i : i);
    value = value << 8U | (from < bytes.size() ? static_cast<unsigned char>(bytes[from]) : 0U);
  }
  return value;
}

/// The orientation in the first directory of a block of EXIF.  [TIFF6]
int exif_orientation(std::string_view exif) {
  constexpr std::string_view kMark("Exif\0\0", 6);  // some programs copy it from JPEG
  if (exif.starts_with(kMark)) exif.remove_prefix(kMark.size());
  const bool is_little = exif.starts_with("II");
  const std::size_t directory = number(exif, 4, 4, is_little);
  const std::size_t entries = number(exif, directory, 2, is_little);
  constexpr std::size_t kEntryBytes = 12, kOrientation = 0x112;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = directory + 2 + kEntryBytes * i;
    if (number(exif, at, 2, is_little) == kOrientation)
      return static_cast<int>(number(exif, at + 8, 2, is_little));
  }
  return 1;
}

constexpr std::size_t kFirstChunk = 12, kHeadBytes = 8;

}  // namespace

WebpSize webp_size(std::string_view bytes) {
  constexpr std::size_t kBody = kFirstChunk + kHeadBytes;
  constexpr std::size_t kLeastBytes = kBody + 10;
  if (bytes.size() < kLeastBytes) return {};
  const auto in_body = [&](std::size_t at, std::size_t count) {
    return number(bytes, kBody + at, count);
  };
  const std::string_view kind = bytes.substr(kFirstChunk, 4);
  if (kind == "VP8X") return {std::int64_t{in_body(4, 3)} + 1, std::int64_t{in_body(7, 3)} + 1};
  if (kind == "VP8 ") return {in_body(6, 2) & 0x3fffU, in_body(8, 2) & 0x3fffU};
  if (kind == "VP8L") {
    const std::uint32_t sizes = in_body(1, 4);
    return {std::int64_t{sizes & 0x3fffU} + 1, std::int64_t{sizes >> 14U & 0x3fffU} + 1};
  }
  return {};
}

int webp_orientation(std::string_view bytes) {
  for (std::size_t at = kFirstChunk; at + kHeadBytes <= bytes.size();) {
    const std::size_t size = number(bytes, at + 4, 4);
    if (bytes.substr(at, 4) == "EXIF") return exif_orientation(bytes.substr(at + kHeadBytes, size));
    at += kHeadBytes + size + size % 2;
  }
  return 1;
}

}  // namespace lucerna

#include "server/pictures/webp_header.h"

#include <cstddef>

#include "server/pictures/picture_checks.h"

namespace lucerna {
namespace {

/// The orientation in the first directory of a block of EXIF.  [TIFF6]
int exif_orientation(std::string_view exif) {
  constexpr std::string_view kMark("Exif\0\0", 6);  // some programs copy it from JPEG
  if (exif.starts_with(kMark)) exif.remove_prefix(kMark.size());
  const std::endian order = exif.starts_with("II") ? std::endian::little : std::endian::big;
  const std::size_t directory = number_at(exif, 4, 4, order);
  const std::size_t entries = number_at(exif, directory, 2, order);
  constexpr std::size_t kEntryBytes = 12, kOrientation = 0x112;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = directory + 2 + kEntryBytes * i;
    if (number_at(exif, at, 2, order) == kOrientation)
      return static_cast<int>(number_at(exif, at + 8, 2, order));
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
    return static_cast<std::int64_t>(number_at(bytes, kBody + at, count, std::endian::little));
  };
  const std::string_view kind = bytes.substr(kFirstChunk, 4);
  if (kind == "VP8X") return {in_body(4, 3) + 1, in_body(7, 3) + 1};
  if (kind == "VP8 ") return {in_body(6, 2) & 0x3fff, in_body(8, 2) & 0x3fff};
  if (kind == "VP8L") {
    const std::int64_t sizes = in_body(1, 4);
    return {(sizes & 0x3fff) + 1, (sizes >> 14 & 0x3fff) + 1};
  }
  return {};
}

int webp_orientation(std::string_view bytes) {
  for (std::size_t at = kFirstChunk; at + kHeadBytes <= bytes.size();) {
    const std::size_t size = number_at(bytes, at + 4, 4, std::endian::little);
    if (bytes.substr(at, 4) == "EXIF") return exif_orientation(bytes.substr(at + kHeadBytes, size));
    at += kHeadBytes + size + size % 2;
  }
  return 1;
}

}  // namespace lucerna

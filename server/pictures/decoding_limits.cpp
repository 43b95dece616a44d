#include "server/pictures/decoding_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "server/pictures/picture_checks.h"

namespace lucerna {
namespace {

/// JPEG and PNG store the first byte of a number first.
std::uint64_t number(std::string_view bytes, std::size_t at, std::size_t count) {
  return number_at(bytes, at, count, std::endian::big);
}

}  // namespace

JpegScans jpeg_scans(std::string_view bytes) {
  constexpr std::size_t kHeight = 3, kWidth = 5;  // from the length of a frame header
  constexpr unsigned kEnd = 0xd9, kScan = 0xda;
  JpegScans found;
  // Between segments there is the data of a scan, in which 0 or a restart follows each 0xff.
  for (std::size_t i = 2; (i = bytes.find('\xff', i)) < bytes.size();) {
    const auto marker = static_cast<unsigned>(number(bytes, ++i, 1));
    if (marker == 0xff || marker <= 1 || (marker >= 0xd0 && marker <= 0xd8)) continue;
    if (marker == kEnd) break;
    ++i;
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      found.texels =
          std::max(found.texels, number(bytes, i + kHeight, 2) * number(bytes, i + kWidth, 2));
      found.is_progressive |= (marker & 3U) == 2;
    }
    if (marker == kScan) found.scans.push_back(i - 2);
    i += number(bytes, i, 2);
  }
  return found;
}

absl::Status check_jpeg_scans(const AssetContent& content) {
  constexpr std::uint64_t kMostScans = 100;                       // as in libtiff
  constexpr std::uint64_t kMostTexels = std::uint64_t{1} << 32U;  // of all scans
  const JpegScans found = jpeg_scans(content.bytes);
  const std::uint64_t most = std::min(kMostScans, kMostTexels / found.texels);
  if (found.scans.size() <= most) return absl::OkStatus();
  return bad_picture(content, fmt::format("{} scans of {} texels, allowed: at most {} scans",
                                          found.scans.size(), found.texels, most));
}

absl::Status check_png_texts(const AssetContent& content) {
  constexpr std::size_t kMostTexts = 16, kFirstChunk = 8, kBesideData = 12;
  std::size_t texts = 0;
  for (std::size_t at = kFirstChunk; at < content.bytes.size();
       at += kBesideData + number(content.bytes, at, 4)) {
    const std::string_view kind = std::string_view(content.bytes).substr(at).substr(0, 8);
    texts += kind.ends_with("zTXt") || kind.ends_with("iTXt") || kind.ends_with("iCCP");
  }
  if (texts <= kMostTexts) return absl::OkStatus();
  return bad_picture(
      content, fmt::format("{} packed texts and profiles, allowed: at most {}", texts, kMostTexts));
}

}  // namespace lucerna

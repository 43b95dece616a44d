#include "server/pictures/webp_header.h"

#include <cstddef>

namespace lucerna {

WebpSize webp_size(std::string_view bytes) {
  constexpr std::size_t kChunk = 12, kBody = 20;
  constexpr std::size_t kLeastBytes = kBody + 10;
  if (bytes.size() < kLeastBytes) return {};
  const auto number = [&](std::size_t at, std::size_t count) {
    std::uint32_t value = 0;
    for (std::size_t i = count; i-- > 0;)
      value = value << 8U | static_cast<unsigned char>(bytes[kBody + at + i]);
    return value;
  };
  const std::string_view kind = bytes.substr(kChunk, 4);
  if (kind == "VP8X") return {std::int64_t{number(4, 3)} + 1, std::int64_t{number(7, 3)} + 1};
  if (kind == "VP8 ") return {number(6, 2) & 0x3fffU, number(8, 2) & 0x3fffU};
  if (kind == "VP8L") {
    const std::uint32_t sizes = number(1, 4);
    return {std::int64_t{sizes & 0x3fffU} + 1, std::int64_t{sizes >> 14U & 0x3fffU} + 1};
  }
  return {};
}

}  // namespace lucerna

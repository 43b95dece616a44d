#include "server/files/printable.h"

#include <algorithm>
#include <cstddef>

namespace lucerna {
namespace {

/// Length in bytes of the well-formed character at the start of `text`; 0 if there is none.
/// [Unicode15, table 3-7]
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) -> unsigned {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
  };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xc0) == 0x80; };
  const unsigned b = byte(0);
  if (b < 0x80) return 1;
  if (b >= 0xc2 && b <= 0xdf) return continues(1) ? 2 : 0;
  if (b >= 0xe0 && b <= 0xef) {
    const bool in_range = (b != 0xe0 || byte(1) >= 0xa0) && (b != 0xed || byte(1) < 0xa0);
    return in_range && continues(1) && continues(2) ? 3 : 0;
  }
  if (b >= 0xf0 && b <= 0xf4) {
    const bool in_range = (b != 0xf0 || byte(1) >= 0x90) && (b != 0xf4 || byte(1) < 0x90);
    return in_range && continues(1) && continues(2) && continues(3) ? 4 : 0;
  }
  return 0;
}

bool is_control(char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }

}  // namespace

std::string printable(std::string_view text) {
  constexpr std::size_t kMaxBytes = 80;
  std::string result;
  while (!text.empty()) {
    const std::size_t length = is_control(text[0]) ? 0 : character_length(text);
    if (result.size() + length > kMaxBytes) return result + "...";
    if (length == 0) {
      result += '?';
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return result;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

bool is_printable(std::string_view text) {
  return is_utf8(text) && std::ranges::none_of(text, is_control);
}

bool is_light_name(std::string_view text) {
  return !text.empty() && text.size() <= kMostLightNameBytes && is_printable(text);
}

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

}  // namespace lucerna

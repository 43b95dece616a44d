#include "proto/common/plain_text.h"

#include <cstddef>
#include <cstdint>

namespace lucerna {
namespace {

constexpr std::uint32_t kNoCharacter = 0xfffd;

struct Character {
  std::uint32_t code;
  std::size_t bytes;
};

/// The first character; kNoCharacter with one byte if it is no UTF-8 [RFC3629].
Character first_of(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {kNoCharacter, 1};
  std::uint32_t code = lead & (0x7fU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {kNoCharacter, 1};
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kLeast[bytes] || surrogate || code > 0x10ffff) return {kNoCharacter, 1};
  return {code, bytes};
}

bool in(std::uint32_t code, std::uint32_t first, std::uint32_t last) {
  return code >= first && code <= last;
}

/// Control characters (C0, DEL, C1), line separators, and the characters of [UAX9] that turn text
/// about.
bool is_obeyed(std::uint32_t code) {
  return code < 0x20 || in(code, 0x7f, 0x9f) || code == 0x61c || in(code, 0x200e, 0x200f) ||
         in(code, 0x2028, 0x202e) || in(code, 0x2066, 0x2069);
}

std::string plain(std::string_view text, bool keep_layout) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const auto [code, bytes] = first_of(text);
    const bool bad = code == kNoCharacter && bytes == 1;
    const bool layout = code == '\n' || code == '\t';
    if (bad || (is_obeyed(code) && !(layout && keep_layout))) {
      char escaped[16];
      (void)std::snprintf(escaped, sizeof escaped, "\\u%04x", code);
      result += escaped;
    } else {
      result += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  return result;
}

}  // namespace

std::string plain_text(std::string_view text) { return plain(text, true); }
std::string plain_line(std::string_view text) { return plain(text, false); }

}  // namespace lucerna

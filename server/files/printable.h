// Text from files: encodings, names, and what fits into messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lucerna {

/// `text` made printable for messages: well-formed UTF-8, no control characters, at most 80 bytes.
std::string printable(std::string_view text);

/// Whether `text` is well-formed UTF-8.
bool is_utf8(std::string_view text);

/// The same, without control characters.
bool is_printable(std::string_view text);

/// Whether `text` may be the name of a light: is_printable(), from 1 to kMostLightNameBytes.
bool is_light_name(std::string_view text);
inline constexpr std::size_t kMostLightNameBytes = 256;

/// `text` without the UTF-8 byte-order mark at its start, which some editors write.
std::string_view without_byte_order_mark(std::string_view text);

}  // namespace lucerna

// Text from files, made fit for messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lucerna {

/// `text` made printable for messages: well-formed UTF-8, no control characters, at most 80 bytes.
std::string printable(std::string_view text);

/// Whether `text` is well-formed UTF-8 without control characters.
bool is_printable(std::string_view text);

/// Whether `text` may be the name of a light: is_printable(), from 1 to kMostLightNameBytes.
bool is_light_name(std::string_view text);
inline constexpr std::size_t kMostLightNameBytes = 256;

}  // namespace lucerna

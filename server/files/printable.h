// Text from files, made fit for messages.
#pragma once

#include <string>
#include <string_view>

namespace lucerna {

/// `text` made printable for messages: well-formed UTF-8, no control characters, at most 80 bytes.
std::string printable(std::string_view text);

/// Whether `text` is well-formed UTF-8 without control characters.
bool is_printable(std::string_view text);

}  // namespace lucerna

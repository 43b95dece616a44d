// The byte-order mark that some editors write at the start of UTF-8.
#pragma once

#include <string_view>

namespace lucerna {

/// `text` without the UTF-8 byte-order mark at its start, if it has one.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

}  // namespace lucerna

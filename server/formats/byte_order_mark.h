// The mark that some editors begin UTF-8 with.
#pragma once

#include <string_view>

namespace lucerna {

/// `text` behind the UTF-8 byte-order mark, where it begins with one.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

}  // namespace lucerna

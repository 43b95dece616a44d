// Text that a terminal or a log shows and does not obey.
#pragma once

#include <string>
#include <string_view>

namespace lucerna {

/// The text with \uXXXX in place of each character that could change the terminal or the order of
/// the text: control characters except tab and new line, and those of bidirectional text.  Bytes
/// that are no UTF-8 become \ufffd.  JSON means the same after this as before.
std::string plain_text(std::string_view text);

/// The same, with tabs and new lines escaped too.
std::string plain_line(std::string_view text);

}  // namespace lucerna

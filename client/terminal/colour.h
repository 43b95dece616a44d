// Colours of the terminal.  There are none in files and pipes, with NO_COLOR (https://no-color.org)
// or with TERM=dumb.
#pragma once

#include <string>

namespace lucerna::shell {

/// Whether text for this file descriptor has colours.
bool has_colours(int descriptor);

enum class Colour { kPlain, kBold, kGood, kWarning, kBad };

/// The text in this colour.  Its length on the screen stays the same.
std::string paint(const std::string& text, Colour colour);

}  // namespace lucerna::shell

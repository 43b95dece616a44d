#include "client/terminal/colour.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace lucerna::shell {

bool has_colours(int descriptor) {
  // The rule of no-color.org: any value but the empty one.
  const char* no_colour = std::getenv("NO_COLOR");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  const char* terminal = std::getenv("TERM");
  if (terminal == nullptr || std::string_view(terminal) == "dumb") return false;
  return ::isatty(descriptor) != 0;
}

std::string paint(const std::string& text, Colour colour) {
  const char* code = nullptr;
  switch (colour) {
    case Colour::kPlain:
      return text;
    case Colour::kBold:
      code = "1";
      break;
    case Colour::kGood:
      code = "32";
      break;
    case Colour::kWarning:
      code = "33";
      break;
    case Colour::kBad:
      code = "31";
      break;
  }
  return text.empty() ? text : "\033[" + std::string(code) + "m" + text + "\033[0m";
}

}  // namespace lucerna::shell

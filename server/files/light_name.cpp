#include "server/files/light_name.h"

#include "server/files/printable.h"

namespace lucerna {

bool is_light_name(std::string_view text) {
  return !text.empty() && text.size() <= kMostLightNameBytes && is_printable(text);
}

}  // namespace lucerna

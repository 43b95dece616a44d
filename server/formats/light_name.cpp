#include "server/formats/light_name.h"

#include "server/formats/printable.h"

namespace lucerna {

bool is_light_name(std::string_view text) {
  return !text.empty() && text.size() <= kMostLightNameBytes && is_printable(text);
}

}  // namespace lucerna

// The names that lights may have.
#pragma once

#include <cstddef>
#include <string_view>

namespace lucerna {

/// Whether `text` may be the name of a light: is_printable(), from 1 to kMostLightNameBytes.
bool is_light_name(std::string_view text);
inline constexpr std::size_t kMostLightNameBytes = 256;

}  // namespace lucerna

// The light that a sample chose.
#pragma once

#include <cstdint>

namespace lucerna {

struct LightChoice {
  std::uint32_t light;
  double probability;
};

}  // namespace lucerna

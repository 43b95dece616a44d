// Numbers that look random but depend only on given values, so that they can be repeated.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <initializer_list>

#include "lights/sampling/sobol.h"

namespace lucerna {

/// A hash of the bits of some numbers, in order.
inline std::uint64_t hash_of(std::initializer_list<double> values) {
  std::uint64_t hash = 0;
  for (const double value : values)
    hash = mix_bits(hash + 0x9e3779b97f4a7c15U + std::bit_cast<std::uint64_t>(value));
  return hash;
}

/// A number in [0, 1) that depends on the bits of these values only.
inline double hash_number(std::initializer_list<double> values) {
  return static_cast<double>(hash_of(values) >> 11) * 0x1p-53;
}

}  // namespace lucerna

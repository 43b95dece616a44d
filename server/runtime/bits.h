// Arrays of bits as in messages: the lowest bit of each byte first.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lucerna {

inline void set_bit(std::uint8_t* bits, std::size_t i) {
  bits[i / 8] |= static_cast<std::uint8_t>(1u << (i % 8));
}

inline bool bit(const std::uint8_t* bits, std::size_t i) {
  return (bits[i / 8] >> (i % 8) & 1) != 0;
}

}  // namespace lucerna

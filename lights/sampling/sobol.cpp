#include "lights/sampling/sobol.h"

namespace lucerna {
namespace {

std::uint32_t reverse_bits(std::uint32_t v) {
  v = __builtin_bswap32(v);
  v = (v & 0x0F0F0F0FU) << 4 | (v >> 4 & 0x0F0F0F0FU);
  v = (v & 0x33333333U) << 2 | (v >> 2 & 0x33333333U);
  return (v & 0x55555555U) << 1 | (v >> 1 & 0x55555555U);
}

/// Reverses the bits of both numbers at once.
struct Reversed {
  std::uint32_t x, y;
};
Reversed reverse_bits(std::uint32_t x, std::uint32_t y) {
  std::uint64_t v = __builtin_bswap64(x | std::uint64_t{y} << 32);  // y is now the lower half
  v = (v & 0x0F0F0F0F0F0F0F0FU) << 4 | (v >> 4 & 0x0F0F0F0F0F0F0F0FU);
  v = (v & 0x3333333333333333U) << 2 | (v >> 2 & 0x3333333333333333U);
  v = (v & 0x5555555555555555U) << 1 | (v >> 1 & 0x5555555555555555U);
  return {static_cast<std::uint32_t>(v >> 32), static_cast<std::uint32_t>(v)};
}

/// Nested uniform scrambling of a number whose digits run from the lowest bit upwards.  A hash of
/// `seed` and the bits below decides whether a bit is flipped.  The idea is [Laine11]'s, the
/// constants are [Vegdahl21]'s.
std::uint32_t scramble_upwards(std::uint32_t v, std::uint32_t seed) {
  v ^= v * 0x3D20ADEAU;
  v += seed;
  v *= (seed >> 16) | 1;
  v ^= v * 0x05526C56U;
  v ^= v * 0x53A22864U;
  return v;
}

/// The second Sobol dimension; digits run from the lowest bit upwards, as in `index`.  Digit j is
/// the parity of all index bits i with binomial(i, j) odd.  By Lucas' theorem, these are the i that
/// have all bits of j.  This is a sum over supersets, which takes five steps.
std::uint32_t pascal(std::uint32_t index) {
  index ^= index >> 16;
  index ^= index >> 8 & 0x00FF00FFU;
  index ^= index >> 4 & 0x0F0F0F0FU;
  index ^= index >> 2 & 0x33333333U;
  return index ^ (index >> 1 & 0x55555555U);
}

float to_unit(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24F; }

}  // namespace

Vec2f SobolSequence::pair(std::uint32_t index, std::uint32_t pair) const {
  const std::uint64_t order = mix_bits(key_ + (2 * std::uint64_t{pair} + 1) * kGolden);
  const std::uint64_t digits = mix_bits(key_ + (2 * std::uint64_t{pair} + 2) * kGolden);
  // Nested scrambling of the index keeps every aligned block of 2^m points together.  [Burley20]
  // Most queries take only point 0.
  const std::uint32_t reversed = index == 0 ? 0 : reverse_bits(index);
  const std::uint32_t shuffled =
      reverse_bits(scramble_upwards(reversed, static_cast<std::uint32_t>(order >> 32)));
  const auto x_seed = static_cast<std::uint32_t>(digits);
  const auto y_seed = static_cast<std::uint32_t>(digits >> 32);
  const Reversed bits =
      reverse_bits(scramble_upwards(shuffled, x_seed), scramble_upwards(pascal(shuffled), y_seed));
  return {to_unit(bits.x), to_unit(bits.y)};
}

}  // namespace lucerna

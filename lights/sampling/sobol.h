// Owen-scrambled Sobol points with the key (seed, item, dimension).  Any point can be computed
// without the points before it, so batches, tiles and threads may split them freely.
#pragma once

#include <cstdint>

#include "lights/maths/vec.h"

namespace lucerna {

/// A 64-bit hash with full avalanche, used to make keys.  The finaliser "Mix13" of the SplitMix
/// generator.  [Steele14]
inline std::uint64_t mix_bits(std::uint64_t v) {
  v = (v ^ v >> 30) * 0xBF58476D1CE4E5B9U;
  v = (v ^ v >> 27) * 0x94D049BB133111EBU;
  return v ^ v >> 31;
}

/// The sample points of one pixel or one batch item.  Every pair of dimensions is a (0,2)-sequence.
/// Nested uniform (Owen) scrambling by a hash of the key scrambles its digits and shuffles its
/// order, so pairs are independent of each other.  [Burley20]
///
/// Thread-compatible; copying is cheap.
class SobolSequence {
 public:
  /// `block` numbers independent randomisations of the same item.
  SobolSequence(std::uint64_t seed, std::uint64_t item, std::uint64_t block = 0)
      : key_(mix_bits(mix_bits(mix_bits(seed + kGolden) + item + kGolden) + block + kGolden)) {}

  /// Point `index` in dimensions (2 pair, 2 pair + 1), each in [0, 1) as multiples of 2^-24, so
  /// that no float rounds to 1.
  Vec2f pair(std::uint32_t index, std::uint32_t pair) const;

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;

  std::uint64_t key_;
};

}  // namespace lucerna

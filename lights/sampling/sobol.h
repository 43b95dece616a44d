// Owen-scrambled Sobol points with the key (seed, item, dimension).  Any point can be computed
// without the points before it, so batches, tiles and threads may split them freely.
#pragma once

#include <cstdint>

#include "lights/maths/vec.h"

namespace lucerna {

/// The sample points of one pixel or one batch item.  Every pair of dimensions is a (0,2)-sequence.
/// Nested uniform (Owen) scrambling by a hash of the key scrambles its digits and shuffles its
/// order, so pairs are independent of each other.  [Burley20]
///
/// Thread-compatible; copying is cheap.
class SobolSequence {
 public:
  /// `replicate` numbers independent randomisations of the same item.
  SobolSequence(std::uint64_t seed, std::uint64_t item, std::uint64_t replicate = 0);

  /// Point `index` in dimensions (2 pair, 2 pair + 1), each in [0, 1) as multiples of 2^-24, so
  /// that no float rounds to 1.
  Vec2<float> pair(std::uint32_t index, std::uint32_t pair) const;

 private:
  std::uint64_t key_;
};

/// A 64-bit hash with full avalanche, used to make keys.
std::uint64_t mix_bits(std::uint64_t v);

}  // namespace lucerna

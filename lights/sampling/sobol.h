// Owen-scrambled Sobol points, keyed by (seed, item, dimension): any point can be had without those
// before it, so batches, tiles and threads may be split at will.
#pragma once

#include <cstdint>

#include "lights/maths/vec.h"

namespace lucerna {

/// The sample points of one pixel or one batch item.  Every pair of dimensions is a (0,2)-sequence
/// of its own, scrambled by nested uniform (Owen) scrambling from a hash of the key, its order
/// shuffled so that pairs are independent of each other.  [Burley20]
///
/// Thread-compatible; copying is free.
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

/// A 64-bit hash with full avalanche; what keys are made with.
std::uint64_t mix_bits(std::uint64_t v);

}  // namespace lucerna

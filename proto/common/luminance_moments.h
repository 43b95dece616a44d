// The statistics of a pixel's luminance that its interval needs.  This is part of the contract
// (Tile.moments): servers and clients that merge tiles must get the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "proto/common/confidence.h"
#include "proto/common/tile_statistics.h"

namespace lucerna {

/// Over independent blocks of equally many samples, in the unit of the pixel.  `mean` of the
/// comments is the mean of all samples.
struct LuminanceMoments {
  BlockStatistics blocks;  ///< of the blocks' means
  /// The sum over blocks of the block's mean of (sample - mean)^k.
  double second = 0, third = 0, fourth = 0;
  /// The largest magnitude of the samples without obstacles between vertices and lights.
  double largest = 0;
  bool partly_hidden = false;    ///< an obstacle darkened some sample
  bool may_be_negative = false;  ///< the pixel filter has negative weights
};

/// Moments of the blocks of `a` and `b` together, which hold na and nb blocks.  [Pebay08]
LuminanceMoments merge(const LuminanceMoments& a, std::uint64_t na, const LuminanceMoments& b,
                       std::uint64_t nb);

/// What IntervalRule needs of `count` blocks with `samples` samples in total.
EstimateMoments estimate_moments(const LuminanceMoments& m, std::uint64_t count,
                                 std::uint64_t samples);

/// The samples of one block, one by one.
class BlockMoments {
 public:
  explicit BlockMoments(bool may_be_negative = false) : may_be_negative_(may_be_negative) {}

  /// `value`: luminance of the sample, times its weight; >= 0 unless samples may be negative.
  /// `unshadowed`: what its magnitude would be without obstacles.
  void add(double value, double unshadowed);
  /// Moments of the block, whose mean luminance is `mean`.
  LuminanceMoments result(double mean) const;

 private:
  double count_ = 0, first_ = 0;
  double sums_[4] = {};  ///< of powers of (value - first value), which loses no digits
  double largest_ = 0;
  bool partly_hidden_ = false;
  bool may_be_negative_;
};

/// The plane Tile.moments, and the moments of a plane.  Bytes that are no whole pixel are ignored.
std::string bytes_of(std::span<const LuminanceMoments> moments);
std::vector<LuminanceMoments> moments_of(std::string_view bytes);
/// Bytes of a pixel in Tile.moments.
inline constexpr std::size_t kMomentBytes = 7 * sizeof(double);

/// An interval rounded to floats, which contains the exact one.
struct FloatInterval {
  float lower, upper;
};
/// `least`: the converged value is not below this number.
FloatInterval rounded_outwards(const ConfidenceInterval& interval, float least = 0);
/// 0, or the most negative float.
float least_value(bool may_be_negative);

/// For each pixel of a tile with a sample count: an interval that holds its converged luminance
/// with 95% confidence.  `blocks`, `samples_per_block`: as in Tile.
std::vector<FloatInterval> pixel_intervals(std::span<const LuminanceMoments> moments,
                                           std::uint64_t blocks, std::uint64_t samples_per_block);

}  // namespace lucerna

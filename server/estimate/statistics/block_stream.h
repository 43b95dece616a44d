// Statistics over blocks that arrive one by one.  The bits are those of BlockMerger
// (proto/common/tile_statistics.h).  At most one run is kept for each binary digit of the number
// of blocks.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "proto/common/tile_statistics.h"

namespace lucerna {

/// Statistics of N channels over the same blocks.
template <std::size_t N>
using ChannelStatistics = std::array<BlockStatistics, N>;

template <std::size_t N>
ChannelStatistics<N> merge(const ChannelStatistics<N>& a, std::uint64_t na,
                           const ChannelStatistics<N>& b, std::uint64_t nb) {
  ChannelStatistics<N> sum;
  for (std::size_t i = 0; i < N; ++i) sum[i] = merge(a[i], na, b[i], nb);
  return sum;
}

/// The standard error of the mean of independent blocks; infinite for one.
inline double standard_error(const BlockStatistics& blocks, double count) {
  return count > 1 ? std::sqrt(blocks.deviation / (count * (count - 1)))
                   : std::numeric_limits<double>::infinity();
}

/// Merges the values of consecutive blocks; they have a function merge(a, na, b, nb).
template <typename Value>
class BlockTotal {
 public:
  explicit BlockTotal(std::uint64_t first_block) : next_(first_block) {}

  /// Adds the value of the next block.
  void add(const Value& value) {
    Run run{next_++, 1, value};
    while (!runs_.empty()) {
      const Run& low = runs_.back();
      if (low.blocks != run.blocks || low.first % (2 * low.blocks) != 0) break;
      run = joined(low, run);
      runs_.pop_back();
    }
    runs_.push_back(run);
  }

  /// All blocks so far.
  Value total() const {
    if (runs_.empty()) return {};
    Run sum = runs_[0];
    for (std::size_t i = 1; i < runs_.size(); ++i) sum = joined(sum, runs_[i]);
    return sum.value;
  }

 private:
  struct Run {
    std::uint64_t first, blocks;
    Value value;
  };

  static Run joined(const Run& low, const Run& high) {
    return {low.first, low.blocks + high.blocks,
            merge(low.value, low.blocks, high.value, high.blocks)};
  }

  std::uint64_t next_;
  // Runs grow to the largest and then shrink.  An array for the largest possible number of
  // runs would have 10 kB to clear for each exact answer.
  std::vector<Run> runs_;
};

/// Statistics of N channels over consecutive blocks.
template <std::size_t N>
class BlockStream {
 public:
  using Channels = ChannelStatistics<N>;

  explicit BlockStream(std::uint64_t first_block) : total_(first_block) {}

  /// Adds the values of the next block.
  void add(const std::array<double, N>& values) {
    Channels channels;
    for (std::size_t i = 0; i < N; ++i) channels[i] = {values[i], 0};
    total_.add(channels);
  }

  /// Statistics of all blocks so far.
  Channels total() const { return total_.total(); }

 private:
  BlockTotal<Channels> total_;
};

}  // namespace lucerna

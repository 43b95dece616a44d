// Statistics over blocks that arrive one by one.  The bits are those of BlockMerger
// (proto/common/tile_statistics.h).  At most one run is kept for each binary digit of the number
// of blocks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/common/tile_statistics.h"

namespace lucerna {

/// Statistics of N channels over consecutive blocks.
template <std::size_t N>
class BlockStream {
 public:
  using Channels = std::array<BlockStatistics, N>;

  explicit BlockStream(std::uint64_t first_block) : next_(first_block) {}

  /// Adds the values of the next block.
  void add(const std::array<double, N>& values) {
    Run run{next_++, 1, {}};
    for (std::size_t i = 0; i < N; ++i) run.channels[i] = {values[i], 0};
    while (!runs_.empty()) {
      const Run& low = runs_.back();
      if (low.blocks != run.blocks || low.first % (2 * low.blocks) != 0) break;
      run = joined(low, run);
      runs_.pop_back();
    }
    runs_.push_back(run);
  }

  /// Statistics of all blocks so far.
  Channels total() const {
    if (runs_.empty()) return {};
    Run sum = runs_[0];
    for (std::size_t i = 1; i < runs_.size(); ++i) sum = joined(sum, runs_[i]);
    return sum.channels;
  }

 private:
  struct Run {
    std::uint64_t first, blocks;
    Channels channels;
  };

  static Run joined(const Run& low, const Run& high) {
    Run run{low.first, low.blocks + high.blocks, {}};
    for (std::size_t i = 0; i < N; ++i)
      run.channels[i] = merge(low.channels[i], low.blocks, high.channels[i], high.blocks);
    return run;
  }

  std::uint64_t next_;
  // Runs grow to the largest and then shrink.  An array for the largest possible number of
  // runs would have 10 kB to clear for each exact answer.
  std::vector<Run> runs_;
};

}  // namespace lucerna

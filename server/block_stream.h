// BlockMerger's rule (proto/tile_statistics.h) for blocks that come one by one: the same bits,
// without keeping more runs than the number of blocks has binary digits.
#pragma once

#include <array>
#include <cstdint>

#include "proto/tile_statistics.h"

namespace lucerna {

/// Statistics of N channels over consecutive blocks.
template <std::size_t N>
class BlockStream {
 public:
  using Channels = std::array<BlockStatistics, N>;

  explicit BlockStream(std::uint64_t first_block) : next_(first_block) {}

  /// The next block's values.
  void add(const std::array<double, N>& values) {
    Run run{next_++, 1, {}};
    for (std::size_t i = 0; i < N; ++i) run.channels[i] = {values[i], 0};
    while (count_ > 0) {
      const Run& low = runs_[count_ - 1];
      if (low.blocks != run.blocks || low.first % (2 * low.blocks) != 0) break;
      run = joined(low, run);
      --count_;
    }
    runs_[count_++] = run;
  }

  /// All blocks so far.
  Channels total() const {
    if (count_ == 0) return {};
    Run sum = runs_[0];
    for (int i = 1; i < count_; ++i) sum = joined(sum, runs_[i]);
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
  int count_ = 0;
  // Sizes of runs rise to the largest and fall again: twice the digits of a block count.
  std::array<Run, 128> runs_;
};

}  // namespace lucerna

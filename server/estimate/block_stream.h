// Statistics over blocks that arrive one by one.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

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

// How samples are grouped into blocks that each know a mean of their own.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace lucerna::rpc {

/// A path's sample may be cut into eight, which are numbered in 32 bits within the block.
inline constexpr std::uint32_t kMostSamplesPerBlock = 1U << 28;

/// The largest power of two that divides `samples` (at least 1) and leaves at least `replicates`
/// blocks, at least 1 and at most kMostSamplesPerBlock.
inline std::uint32_t default_samples_per_block(std::uint32_t samples, std::uint32_t replicates) {
  const std::uint32_t divides = samples & (~samples + 1);
  return std::min(
      {divides, std::bit_floor(std::max(samples / replicates, 1U)), kMostSamplesPerBlock});
}

}  // namespace lucerna::rpc

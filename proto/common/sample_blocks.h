// How samples are grouped into blocks that each know a mean of their own: part of the contract,
// since clients that split a picture by samples must get the blocks of one that is not split.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace lucerna {

/// A path's sample may be cut into eight, which are numbered in 32 bits within the block.
inline constexpr std::uint32_t kMostSamplesPerBlock = 1U << 28;

/// The largest power of two that divides `samples` (at least 1) and leaves at least `replicates`
/// blocks, at least 1 and at most kMostSamplesPerBlock.
inline std::uint32_t default_samples_per_block(std::uint32_t samples, std::uint32_t replicates) {
  const std::uint32_t divides = samples & (~samples + 1);
  return std::min(
      {divides, std::bit_floor(std::max(samples / replicates, 1U)), kMostSamplesPerBlock});
}

/// Of tiles and pictures, whose blocks hold an eighth of the samples each at most.
inline constexpr std::uint32_t kTileReplicates = 8;
/// Of pixels of a target error: beside edges the means of blocks take few values, and of 8 or 16
/// blocks all are often equal, which tells a standard error of 0.
inline constexpr std::uint32_t kTargetReplicates = 32;

/// The largest aligned run of a power of two blocks that begins at `first` and ends by `end`.
inline std::uint64_t aligned_run(std::uint64_t first, std::uint64_t end) {
  const std::uint64_t fits = std::bit_floor(end - first);
  const std::uint64_t aligned = first & (~first + 1);
  return first == 0 ? fits : std::min(fits, aligned);
}

}  // namespace lucerna

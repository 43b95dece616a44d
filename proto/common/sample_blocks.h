// How samples are grouped into blocks, each with its own mean.  This is part of the contract:
// clients that split a picture by samples must get the same blocks as clients that do not.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace lucerna {

/// A sample of a path may be split into eight.  These are numbered in 32 bits within the block.
inline constexpr std::uint32_t kMostSamplesPerBlock = 1U << 28;

/// The largest power of two that divides `samples` (at least 1) and leaves at least `blocks`
/// blocks, at least 1 and at most kMostSamplesPerBlock.
inline std::uint32_t default_samples_per_block(std::uint32_t samples, std::uint32_t blocks) {
  const std::uint32_t divides = samples & (~samples + 1);
  return std::min({divides, std::bit_floor(std::max(samples / blocks, 1U)), kMostSamplesPerBlock});
}

/// Least number of blocks of tiles and pictures, if there are as many samples.
inline constexpr std::uint32_t kTileBlocks = 8;
/// Least number of blocks of a pixel with a target error.  Beside edges the means of blocks take
/// few values, so 8 or 16 blocks are often all equal, with a standard error of 0.
inline constexpr std::uint32_t kTargetReplicates = 32;

/// The largest aligned run of a power of two blocks that begins at `first` and ends by `end`.
inline std::uint64_t aligned_run(std::uint64_t first, std::uint64_t end) {
  const std::uint64_t fits = std::bit_floor(end - first);
  const std::uint64_t aligned = first & (~first + 1);
  return first == 0 ? fits : std::min(fits, aligned);
}

}  // namespace lucerna

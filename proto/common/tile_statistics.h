// The arithmetic of the Tile message (lucerna/v1/render.proto).  This is part of the contract:
// servers and clients that merge tiles must get the same bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lucerna {

/// Statistics of one channel of one pixel over independent blocks of samples.
/// A block's value is the mean of its samples.
struct BlockStatistics {
  double sum = 0;        ///< of the blocks' values
  double deviation = 0;  ///< sum over blocks of (value - mean)^2
};

/// Statistics of the blocks of `a` and `b` together, which hold na and nb blocks.  Symmetric.
/// [Chan83, eq. 2.1]
BlockStatistics merge(const BlockStatistics& a, std::uint64_t na, const BlockStatistics& b,
                      std::uint64_t nb);

/// Merges runs of blocks.  The bits depend on the merged blocks and not on their grouping.  Runs
/// merge as in a binary counter: aligned neighbours of equal power-of-two size first.  At the end
/// the rest merges from the lowest block up.
///
/// Carries `channels` values at once (3 for each pixel, pixels in row order).  Runs arrive in
/// order: each starts where the last one ended.  The size of a run is a power of two, and its first
/// block is a multiple of its size.
class BlockMerger {
 public:
  BlockMerger(std::uint64_t first_block, std::size_t channels);

  /// False, without effect, if the run does not follow the last one or is not aligned.
  bool add(std::uint64_t first_block, std::uint64_t blocks, std::vector<BlockStatistics> run);

  std::uint64_t blocks() const { return next_ - first_; }
  /// All blocks so far.
  std::vector<BlockStatistics> total() const;

 private:
  struct Run {
    std::uint64_t first, blocks;
    std::vector<BlockStatistics> channels;
  };
  std::uint64_t first_, next_;
  std::size_t channels_;
  std::vector<Run> runs_;
};

}  // namespace lucerna

// The arithmetic of the Tile message (lucerna/v1/render.proto).  This is part of the contract:
// servers and clients that merge tiles must get the same bits.
#pragma once

#include <bit>
#include <cstdint>
#include <utility>
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
/// Carries `size` values at once (3 channels for each pixel, pixels in row order; or moments for
/// each pixel).  Values have a function merge(a, na, b, nb).  Runs arrive in order: each starts
/// where the last one ended.  The size of a run is a power of two, and its first block is a
/// multiple of its size.
template <typename Value = BlockStatistics>
class BlockMerger {
 public:
  BlockMerger(std::uint64_t first_block, std::size_t size)
      : first_(first_block), next_(first_block), size_(size) {}

  /// False, without effect, if the run does not follow the last one or is not aligned.
  bool add(std::uint64_t first_block, std::uint64_t blocks, std::vector<Value> run) {
    if (first_block != next_ || !std::has_single_bit(blocks) || first_block % blocks != 0 ||
        run.size() != size_)
      return false;
    next_ += blocks;
    runs_.push_back({first_block, blocks, std::move(run)});
    while (runs_.size() > 1) {
      Run& low = runs_[runs_.size() - 2];
      const Run& high = runs_.back();
      if (low.blocks != high.blocks || low.first % (2 * low.blocks) != 0) break;
      join(low.values, low.blocks, high.values, high.blocks);
      low.blocks *= 2;
      runs_.pop_back();
    }
    return true;
  }

  std::uint64_t blocks() const { return next_ - first_; }

  /// All blocks so far.
  std::vector<Value> total() const {
    if (runs_.empty()) return std::vector<Value>(size_);
    std::vector<Value> sum = runs_.front().values;
    std::uint64_t blocks = runs_.front().blocks;
    for (std::size_t i = 1; i < runs_.size(); ++i) {
      join(sum, blocks, runs_[i].values, runs_[i].blocks);
      blocks += runs_[i].blocks;
    }
    return sum;
  }

 private:
  struct Run {
    std::uint64_t first, blocks;
    std::vector<Value> values;
  };

  static void join(std::vector<Value>& a, std::uint64_t na, const std::vector<Value>& b,
                   std::uint64_t nb) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = merge(a[i], na, b[i], nb);
  }

  std::uint64_t first_, next_;
  std::size_t size_;
  std::vector<Run> runs_;
};

}  // namespace lucerna

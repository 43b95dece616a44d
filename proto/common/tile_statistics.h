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

/// The same for each channel of each pixel.
template <typename Value>
std::vector<Value> merge(std::vector<Value> a, std::uint64_t na, const std::vector<Value>& b,
                         std::uint64_t nb) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = merge(a[i], na, b[i], nb);
  return a;
}

/// Merges runs of consecutive blocks.  The bits depend on the merged blocks and not on their
/// grouping.  Runs merge as in a binary counter: aligned neighbours of equal power-of-two size
/// first.  At the end the rest merges from the lowest block up.  Values have a function
/// merge(a, na, b, nb).
template <typename Value>
class BlockTotal {
 public:
  explicit BlockTotal(std::uint64_t first_block) : first_(first_block), next_(first_block) {}

  /// Adds the next blocks.  Their number is a power of two, and the first one a multiple of it.
  void add(Value value, std::uint64_t blocks = 1) {
    BlockRun run{next_, blocks, std::move(value)};
    next_ += blocks;
    while (!runs_.empty()) {
      BlockRun& low = runs_.back();
      if (low.blocks != run.blocks || low.first % (2 * low.blocks) != 0) break;
      run = joined(std::move(low), run);
      runs_.pop_back();
    }
    runs_.push_back(std::move(run));
  }

  std::uint64_t next_block() const { return next_; }
  std::uint64_t blocks() const { return next_ - first_; }
  /// All blocks so far.
  Value total() const {
    if (runs_.empty()) return {};
    BlockRun sum = runs_.front();
    for (std::size_t i = 1; i < runs_.size(); ++i) sum = joined(std::move(sum), runs_[i]);
    return std::move(sum.value);
  }

 private:
  struct BlockRun {
    std::uint64_t first, blocks;
    Value value;
  };

  static BlockRun joined(BlockRun low, const BlockRun& high) {
    low.value = merge(std::move(low.value), low.blocks, high.value, high.blocks);
    low.blocks += high.blocks;
    return low;
  }

  std::uint64_t first_, next_;
  // Runs grow to the largest and then shrink.  An array for the largest possible number of
  // runs would have 10 kB to clear for each exact answer.
  std::vector<BlockRun> runs_;
};

/// The BlockTotal of `size` values at once: 3 channels for each pixel, pixels in row order; or
/// moments for each pixel.
template <typename Value = BlockStatistics>
class BlockMerger {
 public:
  BlockMerger(std::uint64_t first_block, std::size_t size) : total_(first_block), size_(size) {}

  /// False, without effect, if the run does not follow the last one or is not aligned.
  bool add(std::uint64_t first_block, std::uint64_t blocks, std::vector<Value> run) {
    if (first_block != total_.next_block() || !std::has_single_bit(blocks) ||
        first_block % blocks != 0 || run.size() != size_)
      return false;
    total_.add(std::move(run), blocks);
    return true;
  }

  std::uint64_t blocks() const { return total_.blocks(); }
  /// All blocks so far.
  std::vector<Value> total() const {
    return blocks() == 0 ? std::vector<Value>(size_) : total_.total();
  }

 private:
  BlockTotal<std::vector<Value>> total_;
  std::size_t size_;
};

}  // namespace lucerna

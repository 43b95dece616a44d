#include "proto/common/tile_statistics.h"

#include <bit>
#include <utility>

namespace lucerna {
namespace {

void merge_into(std::vector<BlockStatistics>& a, std::uint64_t na,
                const std::vector<BlockStatistics>& b, std::uint64_t nb) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = merge(a[i], na, b[i], nb);
}

}  // namespace

BlockStatistics merge(const BlockStatistics& a, std::uint64_t na, const BlockStatistics& b,
                      std::uint64_t nb) {
  if (na == 0) return b;
  if (nb == 0) return a;
  const auto count_a = static_cast<double>(na), count_b = static_cast<double>(nb);
  const double difference = b.sum / count_b - a.sum / count_a;
  return {a.sum + b.sum, a.deviation + b.deviation +
                             difference * difference * (count_a * count_b / (count_a + count_b))};
}

BlockMerger::BlockMerger(std::uint64_t first_block, std::size_t channels)
    : first_(first_block), next_(first_block), channels_(channels) {}

bool BlockMerger::add(std::uint64_t first_block, std::uint64_t blocks,
                      std::vector<BlockStatistics> run) {
  if (first_block != next_ || !std::has_single_bit(blocks) || first_block % blocks != 0 ||
      run.size() != channels_)
    return false;
  next_ += blocks;
  runs_.push_back({first_block, blocks, std::move(run)});
  while (runs_.size() > 1) {
    Run& low = runs_[runs_.size() - 2];
    const Run& high = runs_.back();
    if (low.blocks != high.blocks || low.first % (2 * low.blocks) != 0) break;
    merge_into(low.channels, low.blocks, high.channels, high.blocks);
    low.blocks *= 2;
    runs_.pop_back();
  }
  return true;
}

std::vector<BlockStatistics> BlockMerger::total() const {
  if (runs_.empty()) return std::vector<BlockStatistics>(channels_);
  std::vector<BlockStatistics> sum = runs_.front().channels;
  std::uint64_t blocks = runs_.front().blocks;
  for (std::size_t i = 1; i < runs_.size(); ++i) {
    merge_into(sum, blocks, runs_[i].channels, runs_[i].blocks);
    blocks += runs_[i].blocks;
  }
  return sum;
}

}  // namespace lucerna

#include "proto/common/tile_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "server/estimate/block_stream.h"
#include "tests/server/estimate/tiles.h"

namespace lucerna {
namespace {

using testing::same;

std::vector<BlockStatistics> one(double value) { return {{value, 0}}; }

TEST(Merge, GivesSumAndSquaredDeviationOfAllBlocks) {
  // 1, 3 and 5, 7: sums 4 and 12, deviations 2 and 2.  Together: mean 4, 9 + 1 + 1 + 9 = 20.
  const BlockStatistics all = merge(BlockStatistics{4, 2}, 2, BlockStatistics{12, 2}, 2);
  EXPECT_EQ(all.sum, 16);
  EXPECT_EQ(all.deviation, 20);
}

TEST(Merge, IsSymmetricAndKeepsStatisticsMergedWithNone) {
  const BlockStatistics a{0.1, 0.25}, b{1.7, 0.5};
  EXPECT_TRUE(same(merge(a, 3, b, 5), merge(b, 5, a, 3)));
  EXPECT_TRUE(same(merge(a, 3, {}, 0), a));
  EXPECT_TRUE(same(merge({}, 0, a, 3), a));
}

TEST(BlockMerger, RefusesRunsThatDoNotFollowOrAreNotAligned) {
  BlockMerger merger(4, 1);
  EXPECT_FALSE(merger.add(5, 1, one(1)));
  EXPECT_FALSE(merger.add(4, 8, one(1)));  // 4 is no multiple of 8
  EXPECT_FALSE(merger.add(4, 3, one(1)));  // no power of two
  EXPECT_FALSE(merger.add(4, 4, {}));      // no channel
  EXPECT_EQ(merger.blocks(), 0u);
  EXPECT_TRUE(merger.add(4, 4, one(1)));
  EXPECT_FALSE(merger.add(4, 4, one(1)));
  EXPECT_TRUE(merger.add(8, 8, one(1)));
  EXPECT_EQ(merger.blocks(), 12u);
}

std::vector<double> values(std::size_t n) {
  std::mt19937 random(1);
  std::lognormal_distribution<double> distribution(0, 2);
  std::vector<double> v(n);
  for (double& x : v) x = distribution(random);
  return v;
}

TEST(BlockMerger, GivesTheSameBitsForAnySplitIntoAlignedRuns) {
  const std::vector<double> v = values(24);
  const auto run = [&](std::uint64_t first, std::uint64_t blocks) {
    BlockMerger m(first, 1);
    for (std::uint64_t b = first; b < first + blocks; ++b) m.add(b, 1, one(v[b]));
    return m.total();
  };
  const BlockStatistics expected = run(0, 24)[0];
  for (const std::vector<std::uint64_t>& cut :
       {std::vector<std::uint64_t>{16, 8}, {8, 8, 8}, {4, 4, 2, 2, 4, 8}, {1, 1, 2, 4, 8, 4, 4}}) {
    BlockMerger m(0, 1);
    std::uint64_t at = 0;
    for (const std::uint64_t n : cut) {
      ASSERT_TRUE(m.add(at, n, run(at, n)));
      at += n;
    }
    EXPECT_TRUE(same(m.total()[0], expected));
  }
}

TEST(BlockMerger, CompanionShowsThatTheOrderOfMergingChangesTheBits) {
  const std::vector<double> v = values(24);
  BlockMerger merger(0, 1);
  BlockStatistics in_a_row;
  for (std::uint64_t b = 0; b < v.size(); ++b) {
    merger.add(b, 1, one(v[b]));
    in_a_row = merge(in_a_row, b, {v[b], 0}, 1);
  }
  EXPECT_FALSE(same(merger.total()[0], in_a_row));
  EXPECT_NEAR(merger.total()[0].deviation / in_a_row.deviation, 1, 1e-12);
}

TEST(BlockStream, GivesTheSameBitsAsBlockMerger) {
  const std::vector<double> v = values(64);
  for (const std::uint64_t first : {0u, 3u, 8u})
    for (std::uint64_t n = 0; n + first < v.size(); ++n) {
      BlockMerger merger(first, 1);
      BlockStream<1> stream(first);
      for (std::uint64_t b = first; b < first + n; ++b) {
        ASSERT_TRUE(merger.add(b, 1, one(v[b])));
        stream.add({v[b]});
      }
      ASSERT_TRUE(same(merger.total()[0], stream.total()[0])) << first << " " << n;
    }
}

}  // namespace
}  // namespace lucerna

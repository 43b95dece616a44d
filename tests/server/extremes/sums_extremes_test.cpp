// Row 24: sums of very many samples.
#include <gtest/gtest.h>

#include "server/block_stream.h"
#include "tests/sweep.h"

namespace lucerna::testing {
namespace {

TEST(SumsExtremes, Blocks) {
  Sweep sweep(24, "mean of equal samples", "1e8 samples", "mean");
  BlockStream<1> stream(0);
  constexpr std::uint64_t kCount = 1u << 20;
  for (std::uint64_t i = 0; i < kCount; ++i) stream.add({0.1});
  sweep.compare(stream.total()[0].sum / kCount, 0.1, "2^20 blocks");
  float textbook = 0;
  for (std::uint64_t i = 0; i < kCount; ++i) textbook += 0.1F;
  sweep.compare_textbook(textbook / kCount, 0.1);
  sweep.expect_within(1e-15);
}

}  // namespace
}  // namespace lucerna::testing

#include "server/estimate/pilots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lucerna {
namespace {

using ::testing::ElementsAre;

/// The sizes of the pilots for an estimate of 1, and the number of samples that they choose.
struct Chosen {
  std::vector<std::uint64_t> pilots;
  double samples = 0;
};

/// `needed`: the number of samples whose interval is as wide as the target allows.
Chosen choose(double needed, std::uint64_t max_samples) {
  const TargetError target{.relative = 0.01, .max_samples = max_samples};
  Chosen chosen;
  const auto samples = needed_samples(target, [&](const Blocks& b) -> std::optional<PilotEstimate> {
    chosen.pilots.push_back(b.count * b.samples);
    const double off = 0.01 * std::sqrt(needed / static_cast<double>(chosen.pilots.back()));
    return PilotEstimate{.value = 1, .interval = {1 - off, 1 + off}};
  });
  chosen.samples = samples.value_or(0);
  return chosen;
}

// The chosen number is 1.25 times the needed one.
TEST(Pilots, EndWhenSixTimesAsManySamplesSuffice) {
  const Chosen one = choose(5.9 * 64 / 1.25, 65536);
  EXPECT_THAT(one.pilots, ElementsAre(64));
  EXPECT_NEAR(one.samples, 5.9 * 64, 1e-6);
  const Chosen two = choose(6.1 * 64 / 1.25, 65536);
  EXPECT_THAT(two.pilots, ElementsAre(64, 128));
  EXPECT_NEAR(two.samples, 6.1 * 64, 1e-6);
}

TEST(Pilots, GrowTwofoldIfThatSufficesElseFourfold) {
  EXPECT_THAT(choose(11.9 * 64 / 1.25, 65536).pilots, ElementsAre(64, 128));
  EXPECT_THAT(choose(12.1 * 64 / 1.25, 65536).pilots, ElementsAre(64, 256));
  const Chosen many = choose(100 * 64 / 1.25, 65536);
  EXPECT_THAT(many.pilots, ElementsAre(64, 256, 1024, 2048));
  EXPECT_NEAR(many.samples, 6400, 1e-6);
}

TEST(Pilots, TakeAtMostAQuarterOfTheLargestNumber) {
  const Chosen chosen = choose(100 * 64 / 1.25, 1000);
  EXPECT_THAT(chosen.pilots, ElementsAre(64));
  EXPECT_EQ(chosen.samples, 1000);
}

TEST(Pilots, ReturnNothingIfTheyAreStopped) {
  const auto stopped = [](const Blocks&) { return std::optional<PilotEstimate>(); };
  EXPECT_EQ(needed_samples(TargetError{.relative = 0.01}, stopped), std::nullopt);
}

}  // namespace
}  // namespace lucerna

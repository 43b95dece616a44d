#include "server/files/load_budget.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/server/files/limited_pool.h"

namespace lucerna {
namespace {

using testing::LimitedPool;

constexpr std::uint64_t kStep = LoadBudget::kStepBytes;

TEST(LoadBudget, TakesStepsAndTheLastBytesOfThePool) {
  LimitedPool pool(kStep + 10);
  LoadBudget budget(&pool);
  ASSERT_TRUE(budget.claim(1).ok());
  EXPECT_EQ(pool.taken(), kStep);
  ASSERT_TRUE(budget.claim(kStep + 9).ok());
  EXPECT_EQ(pool.taken(), kStep + 10);
  EXPECT_EQ(budget.used(), kStep + 10);
}

TEST(LoadBudget, ARefusedClaimCountsNothingAndIsRemembered) {
  LimitedPool pool(kStep);
  LoadBudget budget(&pool);
  ASSERT_TRUE(budget.claim(100).ok());
  EXPECT_TRUE(budget.refusal().ok());
  EXPECT_TRUE(absl::IsResourceExhausted(budget.claim(kStep)));
  EXPECT_TRUE(absl::IsResourceExhausted(budget.refusal()));
  EXPECT_EQ(budget.used(), 100);
  EXPECT_TRUE(budget.claim(kStep - 100).ok());
}

TEST(LoadBudget, TwoLoadsShareWhatThePoolHas) {
  LimitedPool pool(4 * kStep);
  LoadBudget first(&pool);
  ASSERT_TRUE(first.claim(3 * kStep).ok());
  LoadBudget second(&pool);
  EXPECT_FALSE(second.claim(2 * kStep).ok());
  first.release(2 * kStep);
  EXPECT_TRUE(second.claim(2 * kStep).ok());
}

TEST(LoadBudget, GivesAllBackAtItsEnd) {
  LimitedPool pool;
  {
    LoadBudget budget(&pool);
    ASSERT_TRUE(budget.claim(10 * kStep).ok());
    budget.release(3 * kStep);
    EXPECT_LT(pool.taken(), 9 * kStep);
  }
  EXPECT_EQ(pool.taken(), 0);
}

TEST(LoadBudget, SharesReleaseTheirBytesOnceEach) {
  LimitedPool pool;
  LoadBudget budget(&pool);
  {
    LoadBudget::Share a(&budget);
    ASSERT_TRUE(a.resize(1000).ok());
    ASSERT_TRUE(a.grow(24).ok());
    ASSERT_TRUE(a.resize(600).ok());
    LoadBudget::Share b = std::move(a);
    LoadBudget::Share c;
    c = std::move(b);
    EXPECT_EQ(budget.used(), 600);
  }
  EXPECT_EQ(budget.used(), 0);
}

TEST(LoadBudget, AShareKeepsItsBytesIfItCannotGrow) {
  LimitedPool pool(1000);
  LoadBudget budget(&pool);
  LoadBudget::Share share(&budget);
  ASSERT_TRUE(share.resize(900).ok());
  EXPECT_FALSE(share.resize(1001).ok());
  EXPECT_EQ(share.bytes(), 900);
  EXPECT_EQ(budget.used(), 900);
}

TEST(LoadBudget, WithoutAPoolThereIsNoLimit) {
  LoadBudget budget;
  EXPECT_TRUE(budget.claim(std::uint64_t{1} << 60).ok());
  LoadBudget::Share none;
  EXPECT_TRUE(none.resize(std::uint64_t{1} << 60).ok());
}

}  // namespace
}  // namespace lucerna

// Scenes that are unloaded when there is not room for all.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "server/store/scene_store.h"
#include "tests/server/pbrt/pbrt_fixture.h"

namespace lucerna {
namespace {

using std::chrono::seconds;
using testing::message;
using testing::SceneFiles;

class LeasesTest : public ::testing::Test {
 protected:
  /// `scenes`: the number of this test's scenes that fit.
  void open(double scenes) {
    for (int i = 0; i < 6; ++i) {
      files_.write(name(i), "WorldBegin # " + std::to_string(i) +
                                "\nShape \"sphere\"\nLightSource \"point\"\n");
    }
    std::uint64_t one = 0;
    {
      const auto unlimited = SceneStore::open({.root = files_.path().string()}).value();
      const auto scene = unlimited->load(name(0)).value().stored.scene;
      for (const ScenePart& part : scene->parts()) one += part.bytes;
      ASSERT_GT(one, 0U);
    }
    store_ = SceneStore::open({.root = files_.path().string(),
                               .memory_budget_bytes =
                                   static_cast<std::uint64_t>(scenes * static_cast<double>(one)),
                               .max_lease_s = 100,
                               .now = [this] { return now_; }})
                 .value();
  }
  static std::string name(int i) { return fmt::format("s{}.pbrt", i); }
  /// Loads scene i and returns its id.
  std::string load(int i, double lease_s = 0) {
    auto loaded = store_->load(name(i), {.lease_s = lease_s});
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    if (!loaded.ok()) return "";
    lease_ = loaded->lease;
    return loaded->stored.scene->id();
  }

  SceneFiles files_;
  std::chrono::steady_clock::time_point now_ = std::chrono::steady_clock::now();
  std::unique_ptr<SceneStore> store_;
  Lease lease_;  // of the last load
};

TEST_F(LeasesTest, LeastRecentlyUsedScenesAreUnloadedFirst) {
  open(2.5);
  const std::string a = load(0), b = load(1);
  EXPECT_NE(store_->find(a), nullptr);  // used after b
  const std::string c = load(2);
  EXPECT_EQ(store_->size(), 2U);
  EXPECT_NE(store_->find(a), nullptr);
  EXPECT_EQ(store_->find(b), nullptr);
  EXPECT_NE(store_->find(c), nullptr);
  EXPECT_FALSE(store_->load(name(1))->already_loaded);
  EXPECT_EQ(store_->find(a), nullptr);
}

TEST_F(LeasesTest, WithoutABudgetAllStay) {
  open(0);
  for (int i = 0; i < 6; ++i) load(i);
  EXPECT_EQ(store_->size(), 6U);
}

TEST_F(LeasesTest, LeasedScenesAreNotUnloadedByOthers) {
  open(2.5);
  const std::string a = load(0, 10);
  EXPECT_FALSE(lease_.id.empty());
  EXPECT_EQ(lease_.seconds, 10);
  const std::string b = load(1), c = load(2);
  EXPECT_NE(store_->find(a), nullptr);
  EXPECT_EQ(store_->find(b), nullptr);
  load(3, 20);
  EXPECT_EQ(store_->find(c), nullptr);
  // Two leases fill the store.
  const absl::Status full = store_->load(name(4)).status();
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(full.GetPayload(kRetryAfterPayload), absl::Cord("10000"));
  EXPECT_EQ(store_->size(), 2U);
  EXPECT_EQ(store_->release(a).status().code(), absl::StatusCode::kFailedPrecondition);
  now_ += seconds(10);
  EXPECT_TRUE(store_->load(name(4)).ok());
  EXPECT_EQ(store_->find(a), nullptr);
}

TEST_F(LeasesTest, ASceneThatNeverFitsIsRefusedAndNoneIsUnloaded) {
  open(0.5);
  const absl::Status status = store_->load(name(0)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_FALSE(status.GetPayload(kRetryAfterPayload).has_value());
  EXPECT_EQ(store_->size(), 0U);
}

TEST_F(LeasesTest, LeasesAreRenewed) {
  open(1.5);
  const std::string a = load(0, 10);
  const Lease first = lease_;
  now_ += seconds(9);
  const auto renewed = store_->lease(a, first.id, 10);
  ASSERT_TRUE(renewed.ok()) << renewed.status();
  EXPECT_EQ(renewed->id, first.id);
  now_ += seconds(9);
  EXPECT_DOUBLE_EQ(store_->stored(a)->leased_s, 1);
  EXPECT_FALSE(store_->load(name(1)).ok());
  now_ += seconds(1);
  EXPECT_EQ(store_->stored(a)->leased_s, 0);
  EXPECT_EQ(store_->lease(a, first.id, 10).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->lease("f00", "", 10).status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(store_->load(name(1)).ok());
}

TEST_F(LeasesTest, NoLeaseIsLongerThanTheServerAllows) {
  open(0);
  load(0, 1e300);
  EXPECT_EQ(lease_.seconds, 100);
  EXPECT_EQ(store_->lease(store_->list("", 1)[0].scene->id(), "", 101)->seconds, 100);
}

TEST_F(LeasesTest, ASceneStaysAsLongAsOneLeaseHoldsIt) {
  open(0);
  const std::string a = load(0, 10);
  const Lease first = lease_;
  EXPECT_EQ(load(0, 50), a);
  const Lease second = lease_;
  EXPECT_NE(first.id, second.id);
  EXPECT_EQ(store_->release(a, "other").status().code(), absl::StatusCode::kNotFound);
  EXPECT_FALSE(store_->release(a, second.id).value());
  EXPECT_NE(store_->find(a), nullptr);
  EXPECT_TRUE(store_->release(a, first.id).value());
  EXPECT_EQ(store_->find(a), nullptr);
}

}  // namespace
}  // namespace lucerna

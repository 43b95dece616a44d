// A scene held from frame to frame, on a server whose answers the test decides.
#include "client/library/held_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "tests/client/library/fake_server.h"

namespace lucerna::client {
namespace {

using ::testing::ElementsAre;

class HeldSceneTest : public ::testing::Test {
 protected:
  HeldSceneTest() {
    server_.renew_lease = [this](auto&, const v1::RenewLeaseRequest& q, auto* r) {
      note("renew " + q.lease_id() + (q.lease_s() < 1 ? " not" : ""));
      r->set_lease_id(q.lease_id());
      return renewed_;
    };
    server_.release_scene = [this](auto&, const v1::ReleaseSceneRequest& q, auto*) {
      note("release " + q.lease_id());
      return released_;
    };
  }
  void note(const std::string& what) {
    const std::lock_guard lock(mutex_);
    calls_.push_back(what);
  }
  /// Grants the leases "1", "2", ...
  absl::StatusOr<v1::LoadSceneResponse> load() {
    note("load");
    v1::LoadSceneResponse r;
    r.set_scene_id("scene");
    r.set_already_loaded(there_);
    r.set_lease_id(std::to_string(++leases_));
    return r;
  }
  HeldScene::Load loader(HeldScene& held) {
    return held.through([this](const auto&, const auto&) { return load(); });
  }

  FakeServer server_;
  grpc::Status renewed_, released_;
  bool there_ = false;
  int leases_ = 0;
  std::mutex mutex_;
  std::vector<std::string> calls_;
  const client::CallOptions call_ = client::CallOptions::within(std::chrono::minutes(10));
};

TEST_F(HeldSceneTest, IsLoadedOnceAndItsLeaseRenewed) {
  HeldScene held;
  for (int i = 0; i < 3; ++i) {
    // Each job has its own connection.
    const auto answer = loader(held)(server_.client(), call_);
    ASSERT_TRUE(answer.ok()) << answer.status();
    EXPECT_EQ(answer->scene_id(), "scene");
    EXPECT_EQ(answer->lease_id(), "1");
  }
  EXPECT_THAT(calls_, ElementsAre("load", "renew 1", "renew 1"));
}

TEST_F(HeldSceneTest, IsLoadedAgainAfterItsLeaseExpired) {
  HeldScene held;
  ASSERT_TRUE(loader(held)(server_.client(), call_).ok());
  renewed_ = {grpc::StatusCode::NOT_FOUND, "no such lease"};
  there_ = true;  // the scene is still loaded
  EXPECT_EQ(loader(held)(server_.client(), call_)->lease_id(), "2");
  // It was not loaded before the first time.
  held.release(true, call_);
  EXPECT_THAT(calls_, ElementsAre("load", "renew 1", "load", "release 2"));
}

TEST_F(HeldSceneTest, ALeaseThatMayStillExistIsNotReplaced) {
  HeldScene held;
  ASSERT_TRUE(loader(held)(server_.client(), call_).ok());
  renewed_ = {grpc::StatusCode::CANCELLED, "the job ended"};
  EXPECT_EQ(loader(held)(server_.client(), call_).status().code(), absl::StatusCode::kCancelled);
  EXPECT_THAT(calls_, ElementsAre("load", "renew 1"));
}

TEST_F(HeldSceneTest, LoadingContinuesForTheNextJob) {
  std::promise<void> begun, door;
  HeldScene held;
  const auto slow = held.through([&](const auto&, const auto&) {
    begun.set_value();
    door.get_future().wait();
    return load();
  });
  std::stop_source first;
  auto given_up = std::async(std::launch::async, [&] {
    return slow(server_.client(), {.deadline = call_.deadline, .stop = first.get_token()});
  });
  begun.get_future().wait();
  first.request_stop();
  EXPECT_EQ(given_up.get().status().code(), absl::StatusCode::kCancelled);
  auto next = std::async(std::launch::async, [&] { return slow(server_.client(), call_); });
  door.set_value();
  const auto answer = next.get();
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->lease_id(), "1");
  held.release(true, call_);
  EXPECT_EQ(std::count(calls_.begin(), calls_.end(), "load"), 1);
  EXPECT_EQ(calls_.back(), "release 1");
}

TEST_F(HeldSceneTest, OnlyScenesThatItLoadedAreUnloaded) {
  HeldScene held;
  there_ = true;
  ASSERT_TRUE(loader(held)(server_.client(), call_).ok());
  held.release(true, call_);
  there_ = false;
  ASSERT_TRUE(loader(held)(server_.client(), call_).ok());
  held.release(false, call_);
  ASSERT_TRUE(loader(held)(server_.client(), call_).ok());
  held.release(true, call_);
  held.release(true, call_);  // of nothing
  EXPECT_THAT(calls_,
              ElementsAre("load", "renew 1 not", "load", "renew 2 not", "load", "release 3"));
}

TEST_F(HeldSceneTest, IsUnloadedAlsoAfterTheLeaseExpired) {
  HeldScene held;
  ASSERT_TRUE(loader(held)(server_.client(), call_).ok());
  released_ = {grpc::StatusCode::NOT_FOUND, "no such lease"};
  held.release(true, call_);
  EXPECT_THAT(calls_, ElementsAre("load", "release 1", "release "));
}

TEST_F(HeldSceneTest, AllServersAreReleasedInParallel) {
  // Each answers after both were called.
  FakeServer other;
  std::condition_variable changed;
  int called = 0, answered = 0;
  const auto together = [&](auto&, const auto&, auto*) {
    std::unique_lock lock(mutex_);
    ++called;
    changed.notify_all();
    if (changed.wait_for(lock, std::chrono::minutes(10), [&] { return called == 2; })) ++answered;
    return grpc::Status::OK;
  };
  for (const bool forget : {true, false}) {
    HeldScene held;
    for (FakeServer* server : {&server_, &other})
      ASSERT_TRUE(loader(held)(server->client(), call_).ok());
    for (FakeServer* server : {&server_, &other}) {
      server->release_scene = together;
      server->renew_lease = together;
    }
    called = answered = 0;
    held.release(forget, call_);
    EXPECT_EQ(answered, 2) << forget;
  }
}

TEST_F(HeldSceneTest, FailuresAreReportedAndRetried) {
  HeldScene held;
  int tries = 0;
  const auto flaky =
      held.through([&](const auto&, const auto&) -> absl::StatusOr<v1::LoadSceneResponse> {
        if (++tries == 1) return absl::UnavailableError("not yet");
        return load();
      });
  EXPECT_EQ(flaky(server_.client(), call_).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(flaky(server_.client(), call_).ok());
  held.release(true, call_);
  EXPECT_THAT(calls_, ElementsAre("load", "release 1"));
}

}  // namespace
}  // namespace lucerna::client

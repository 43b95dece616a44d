// Jobs whose servers join, leave, lose the scene or do not match each other.
#include <absl/strings/match.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>

#include "job_fixture.h"

namespace lucerna::client {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// Whether one of many attempts succeeds.  A machine that pauses may spoil some.
bool one_succeeds(const std::function<bool()>& attempt) {
  for (int i = 0; i < 100; ++i)
    if (attempt()) return true;
  return false;
}

TEST_F(JobTest, AServerThatLostTheSceneGetsItAgain) {
  std::atomic<int> loads = 0;
  listed_.pop_back();
  servers_[0].load_scene = [&](auto&, auto&, v1::LoadSceneResponse* response) {
    ++loads;
    response->set_scene_id("scene");
    return grpc::Status::OK;
  };
  std::atomic<int> calls = 0;
  servers_[0].render_tile = [&](auto&, const v1::RenderTileRequest& request,
                                v1::RenderTileResponse* response) {
    if (++calls == 5) return grpc::Status(grpc::StatusCode::NOT_FOUND, "scene_id");
    return answer(servers_[0], request, response);
  };
  Tiles work(20);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
  EXPECT_EQ(loads.load(), 2);
}

TEST_F(JobTest, AnAnswerMayComeWhileItsServerIsPreparedAgain) {
  // A piece from before that counts.
  listed_.pop_back();
  std::atomic<int> loads = 0;
  std::promise<void> counts;
  options_.on_progress = [&](const JobProgress& progress) {
    if (progress.done == 1 && progress.servers == 0) counts.set_value();
  };
  servers_[0].load_scene = [&](auto&, auto&, v1::LoadSceneResponse* response) {
    if (++loads == 2) {
      door_.open();
      EXPECT_EQ(counts.get_future().wait_for(std::chrono::minutes(10)), std::future_status::ready);
    }
    response->set_scene_id("scene");
    return grpc::Status::OK;
  };
  servers_[0].render_tile = [&](grpc::ServerContext& context, const v1::RenderTileRequest& request,
                                v1::RenderTileResponse* response) {
    if (request.seed() == 1 && loads == 1)
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "scene_id");
    door_.wait(context);
    return answer(servers_[0], request, response);
  };
  Tiles work(2);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
  EXPECT_EQ(loads.load(), 2);
}

TEST_F(JobTest, ServersOfOtherFingerprintsAreNotMixed) {
  servers_[1].fingerprint = "g";
  {
    Tiles work(100);
    const auto report = run_job(work, options_);
    EXPECT_EQ(report.status().code(), absl::StatusCode::kFailedPrecondition) << report.status();
    EXPECT_THAT(std::string(report.status().message()), HasSubstr("fingerprints"));
  }
  Tiles work(100);
  options_.allow_mixed = true;
  const auto report = run_job(work, options_);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->fingerprints.size(), 2U);
}

TEST_F(JobTest, ServersWithOtherScenesEndTheJob) {
  servers_[1].load_scene = [](auto&, auto&, v1::LoadSceneResponse* response) {
    response->set_scene_id("another");
    return grpc::Status::OK;
  };
  for (FakeServer& server : servers_) {
    server.render_tile = [this](grpc::ServerContext& context, auto&, auto*) {
      never_.wait(context);
      return grpc::Status::CANCELLED;
    };
  }
  Tiles work(100);
  const auto report = run_job(work, options_);
  EXPECT_EQ(report.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(report.status().message()), HasSubstr("their files differ"));
}

TEST_F(JobTest, ServersMayJoinAndLeave) {
  const std::string first = servers_[0].target(), second = servers_[1].target();
  listed_ = {first};
  servers_[0].render_tile = [&, second](grpc::ServerContext& context,
                                        const v1::RenderTileRequest& request,
                                        v1::RenderTileResponse* response) {
    if (request.seed() > 10) {
      {
        const std::lock_guard lock(mutex_);
        listed_ = {second};
      }
      never_.wait(context);
      return grpc::Status::CANCELLED;
    }
    return answer(servers_[0], request, response);
  };
  Tiles work(30);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
  EXPECT_EQ(answers(0), 10);
  EXPECT_EQ(answers(1), 20);
  EXPECT_THAT(events_, Contains(first + " left"));
  EXPECT_THAT(events_, Contains(second + " answers"));
}

TEST_F(JobTest, WaitsWhileNoServerAnswersAndReportsIt) {
  const std::string real = servers_[0].target();
  listed_ = {"127.0.0.1:1"};
  options_.on_event = [&](const std::string& event) {
    events_.push_back(event);
    if (event != "no server answers: waiting") return;
    const std::lock_guard lock(mutex_);
    listed_.push_back(real);
  };
  Tiles work(3);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_THAT(events_, Contains("no server answers: waiting"));
}

TEST_F(JobTest, EndsIfNoServerAnswersForItsPatience) {
  listed_ = {"127.0.0.1:1"};
  options_.patience = std::chrono::seconds(1);
  options_.call = {};
  Tiles work(3);
  EXPECT_TRUE(one_succeeds([&] {
    const auto never = run_job(work, options_);
    EXPECT_TRUE(absl::IsUnavailable(never.status())) << never.status();
    return absl::StrContains(never.status().message(), "no server answered for 1 s; 127.0.0.1:1: ");
  }));
  listed_ = {};
  EXPECT_THAT(std::string(run_job(work, options_).status().message()),
              HasSubstr("the list of servers is empty"));
}

TEST_F(JobTest, ADeadlineReplacesThePatience) {
  listed_ = {"127.0.0.1:1"};
  options_.patience = std::chrono::seconds(0);
  options_.call = CallOptions::within(std::chrono::seconds(1));
  Tiles work(3);
  EXPECT_TRUE(absl::IsDeadlineExceeded(run_job(work, options_).status()));
}

TEST_F(JobTest, AServerThatLoadsTheSceneAnswers) {
  options_.patience = std::chrono::seconds(1);
  options_.call = {};
  options_.load = [load = options_.load](const Client& client, const CallOptions& call) {
    // Until a job without servers has lost the same patience.
    Tiles nothing(1);
    JobOptions none;
    none.servers = [] { return std::vector<std::string>(); };
    none.patience = std::chrono::seconds(1);
    const auto lost = run_job(nothing, none);
    EXPECT_TRUE(absl::IsUnavailable(lost.status())) << lost.status();
    return load(client, call);
  };
  EXPECT_TRUE(one_succeeds([&] {
    Tiles work(3);
    return run_job(work, options_).ok();
  }));
}

}  // namespace
}  // namespace lucerna::client

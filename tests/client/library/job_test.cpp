// Jobs on servers whose answers the test decides.
#include "lucerna/client/job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "job_fixture.h"

namespace lucerna::client {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

grpc::Status retry(grpc::StatusCode code, int milliseconds) {
  google::rpc::RetryInfo info;
  info.mutable_retry_delay()->set_nanos(milliseconds * 1'000'000);
  google::rpc::Status wire;
  wire.set_code(code);
  wire.add_details()->PackFrom(info);
  return {code, "busy", wire.SerializeAsString()};
}

TEST_F(JobTest, EveryPieceIsAcceptedOnce) {
  Tiles work(200);
  std::size_t last = 0;
  options_.on_progress = [&](const JobProgress& p) {
    EXPECT_GE(p.done, last);
    EXPECT_EQ(p.pieces, 200U);
    last = p.done;
  };
  const auto report = run_job(work, options_);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_TRUE(work.each_once());
  EXPECT_EQ(last, 200U);
  EXPECT_EQ(work.begun_, 1);
  EXPECT_THAT(report->fingerprints, ElementsAre("f"));
  EXPECT_GT(answers(0), 0);
  EXPECT_GT(answers(1), 0);
}

TEST_F(JobTest, AJobWithoutPiecesEndsAtOnce) {
  Tiles work(0);
  EXPECT_TRUE(run_job(work, options_).ok());
}

TEST_F(JobTest, AServerThatHangsDoesNotStopTheJob) {
  servers_[0].render_tile = [this](grpc::ServerContext& context, auto&, auto*) {
    never_.wait(context);
    return grpc::Status::CANCELLED;
  };
  Tiles work(50);
  const auto report = run_job(work, options_);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_TRUE(work.each_once());
  EXPECT_EQ(answers(1), 50);
}

TEST_F(JobTest, TheFirstOfTwoResultsCounts) {
  // The first server of the first piece answers only after the other one.
  for (FakeServer& server : servers_) {
    server.render_tile = [&](grpc::ServerContext& context, const v1::RenderTileRequest& request,
                             v1::RenderTileResponse* response) {
      if (request.seed() == 1 && first_++ == 0) door_.wait(context);
      return answer(server, request, response);
    };
  }
  Tiles work(3);
  options_.on_progress = [&](const JobProgress& p) {
    if (p.done == 3) door_.open();
  };
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
  EXPECT_GE(first_.load(), 2);
}

TEST_F(JobTest, OtherServersDoTheFailedPieces) {
  servers_[0].render_tile = [](auto&, auto&, auto*) {
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining");
  };
  Tiles work(20);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
  EXPECT_THAT(events_, Contains(HasSubstr(servers_[0].target() + " does not answer: draining")));
}

TEST_F(JobTest, AnErrorOfBeginEndsTheJob) {
  Tiles work(5);
  work.cannot_begin_ = absl::InvalidArgumentError("too many");
  EXPECT_EQ(run_job(work, options_).status().message(), "too many");
  EXPECT_EQ(work.begun_, 1);
  EXPECT_EQ(answers(0) + answers(1), 0);
}

TEST_F(JobTest, RepeatedNotFoundEndsTheJob) {
  for (FakeServer& server : servers_) {
    server.render_tile = [](auto&, auto&, auto*) {
      return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such light");
    };
  }
  Tiles work(5);
  const auto report = run_job(work, options_);
  EXPECT_EQ(report.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(report.status().message()), HasSubstr("no such light"));
}

TEST_F(JobTest, ABusyServerIsRetried) {
  std::atomic<int> calls = 0;
  listed_.pop_back();
  servers_[0].render_tile = [&](auto&, const v1::RenderTileRequest& request,
                                v1::RenderTileResponse* response) {
    if (++calls <= 3) return retry(grpc::StatusCode::RESOURCE_EXHAUSTED, 1);
    return answer(servers_[0], request, response);
  };
  Tiles work(5);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
}

TEST_F(JobTest, AnInvalidRequestEndsTheJobWithTheServersError) {
  servers_[1].render_tile = [](auto&, auto&, auto*) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "light_id = 7");
  };
  Tiles work(100);
  const auto report = run_job(work, options_);
  EXPECT_EQ(report.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(report.status().message()),
              HasSubstr(servers_[1].target() + ": light_id = 7"));
}

TEST_F(JobTest, ASceneThatCannotBeLoadedEndsTheJob) {
  servers_[0].load_scene = [](auto&, auto&, auto*) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "room.pbrt:1:1: what");
  };
  listed_.pop_back();
  Tiles work(1);
  EXPECT_THAT(run_job(work, options_).status().ToString(), HasSubstr("room.pbrt:1:1: what"));
}

TEST_F(JobTest, EndsOnAStopRequestAndAtItsDeadline) {
  for (FakeServer& server : servers_) {
    server.render_tile = [this](grpc::ServerContext& context, auto&, auto*) {
      never_.wait(context);
      return grpc::Status::CANCELLED;
    };
  }
  Tiles work(3);
  std::stop_source stop;
  options_.call.stop = stop.get_token();
  const std::jthread stopper([&] {
    while (answers(0) + answers(1) == 0 && servers_[0].info_calls + servers_[1].info_calls < 2)
      std::this_thread::yield();
    stop.request_stop();
  });
  EXPECT_EQ(run_job(work, options_).status().code(), absl::StatusCode::kCancelled);
  options_.call = CallOptions::within(std::chrono::milliseconds(100));
  EXPECT_EQ(run_job(work, options_).status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST_F(JobTest, AnErrorOfAcceptEndsTheJob) {
  Tiles work(10);
  work.refuse_ = 4;
  EXPECT_EQ(run_job(work, options_).status().message(), "the disk is full");
  options_.servers = []() -> absl::StatusOr<std::vector<std::string>> {
    return absl::UnavailableError("no list");
  };
  EXPECT_EQ(run_job(work, options_).status().message(), "no list");
}

}  // namespace
}  // namespace lucerna::client

// Jobs on servers whose answers a test decides.
#include "lucerna/client/job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "fake_server.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace lucerna::client {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Piece i asks for a tile of seed i + 1, and is answered with what the server makes of it.
class Tiles final : public Work {
 public:
  explicit Tiles(std::size_t n) : taken_(n) {}
  absl::Status begin(const v1::SceneSummary& scene,
                     const v1::GetServerInfoResponse& server) override {
    ++begun_;
    EXPECT_FALSE(scene.scene_id().empty());
    EXPECT_FALSE(server.fingerprint().digest().empty());
    return cannot_begin_;
  }
  std::size_t size() const override { return taken_.size(); }
  void start(std::size_t piece, const Client& client, const std::string& scene_id,
             const CallOptions& options, Done done) override {
    v1::RenderTileRequest request;
    request.set_scene_id(scene_id);
    request.set_seed(piece + 1);
    client.render_tile(request, options, answer_as<v1::RenderTileResponse>(std::move(done)));
  }
  absl::Status accept(std::size_t piece, Result result) override {
    EXPECT_EQ(static_cast<v1::RenderTileResponse&>(*result).cost().samples(), piece + 1);
    ++taken_[piece];
    return refuse_ == piece ? absl::UnknownError("the disk is full") : absl::OkStatus();
  }
  bool each_once() const {
    return std::all_of(taken_.begin(), taken_.end(), [](int n) { return n == 1; });
  }

  std::size_t refuse_ = ~std::size_t{0};
  absl::Status cannot_begin_;
  int begun_ = 0;

 private:
  std::vector<int> taken_;
};

/// A door that calls wait at.
class Door {
 public:
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    opened_.notify_all();
  }
  /// Until it is open, or the call is given up.
  void wait(grpc::ServerContext& context) {
    std::unique_lock lock(mutex_);
    while (!open_ && !context.IsCancelled()) opened_.wait_for(lock, std::chrono::milliseconds(10));
  }

 private:
  std::mutex mutex_;
  std::condition_variable opened_;
  bool open_ = false;
};

grpc::Status retry(grpc::StatusCode code, int milliseconds) {
  google::rpc::RetryInfo info;
  info.mutable_retry_delay()->set_nanos(milliseconds * 1'000'000);
  google::rpc::Status wire;
  wire.set_code(code);
  wire.add_details()->PackFrom(info);
  return {code, "busy", wire.SerializeAsString()};
}

class JobTest : public ::testing::Test {
 protected:
  JobTest() {
    for (FakeServer& server : servers_) {
      server.load_scene = [](auto&, auto&, v1::LoadSceneResponse* response) {
        response->set_scene_id("scene");
        return grpc::Status::OK;
      };
      server.get_scene = [](auto&, const v1::GetSceneRequest& request,
                            v1::GetSceneResponse* response) {
        response->mutable_summary()->set_scene_id(request.scene_id());
        return grpc::Status::OK;
      };
      server.render_tile = [this, &server](auto&, const v1::RenderTileRequest& request,
                                           v1::RenderTileResponse* response) {
        return answer(server, request, response);
      };
    }
    options_.servers = [this]() -> absl::StatusOr<std::vector<std::string>> {
      const std::lock_guard lock(mutex_);
      return listed_;
    };
    options_.load = [](const Client& client, const CallOptions& call) {
      v1::LoadSceneRequest request;
      request.set_path("room.pbrt");
      return client.load_scene(request, call);
    };
    options_.call = CallOptions::within(std::chrono::seconds(60));
    options_.on_event = [this](const std::string& event) { events_.push_back(event); };
    listed_ = {servers_[0].target(), servers_[1].target()};
  }

  grpc::Status answer(FakeServer& server, const v1::RenderTileRequest& request,
                      v1::RenderTileResponse* response) {
    EXPECT_EQ(request.scene_id(), "scene");
    response->mutable_cost()->set_samples(request.seed());
    const std::lock_guard lock(mutex_);
    ++answers_[&server];
    return grpc::Status::OK;
  }
  int answers(int server) {
    const std::lock_guard lock(mutex_);
    return answers_[&servers_[server]];
  }

  std::mutex mutex_;
  // Of the fixture: calls that were given up may wait here until the servers are gone.
  Door never_, door_;
  std::atomic<int> first_ = 0;
  std::map<FakeServer*, int> answers_;
  std::vector<std::string> listed_;
  std::vector<std::string> events_;
  FakeServer servers_[2];
  JobOptions options_;
};

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

TEST_F(JobTest, NothingToDoIsDoneAtOnce) {
  Tiles work(0);
  EXPECT_TRUE(run_job(work, options_).ok());
}

TEST_F(JobTest, AServerThatHangsIsDoneWithout) {
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
  // The first piece's first server answers only after the other has.
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

TEST_F(JobTest, WhatAServerFailsAtOthersDo) {
  servers_[0].render_tile = [](auto&, auto&, auto*) {
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining");
  };
  Tiles work(20);
  ASSERT_TRUE(run_job(work, options_).ok());
  EXPECT_TRUE(work.each_once());
  EXPECT_THAT(events_, Contains(HasSubstr(servers_[0].target() + " does not answer: draining")));
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

TEST_F(JobTest, AnAnswerMayComeWhileItsServerIsMadeReadyAgain) {
  // The second piece is answered when nothing but its call holds on to the connection: gRPC must
  // not be the one to end that.
  listed_.pop_back();
  std::atomic<int> loads = 0;
  servers_[0].load_scene = [&](auto&, auto&, v1::LoadSceneResponse* response) {
    if (++loads == 2) {
      door_.open();
      for (int i = 0; i < 1000 && answers(0) == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
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

TEST_F(JobTest, WorkThatCannotBeginEndsIt) {
  Tiles work(5);
  work.cannot_begin_ = absl::InvalidArgumentError("too many");
  EXPECT_EQ(run_job(work, options_).status().message(), "too many");
  EXPECT_EQ(work.begun_, 1);
  EXPECT_EQ(answers(0) + answers(1), 0);
}

TEST_F(JobTest, WhatIsNotFoundAgainAndAgainEndsIt) {
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

TEST_F(JobTest, AServerThatIsBusyIsAskedLater) {
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

TEST_F(JobTest, AWrongRequestEndsItWithWhatTheServerSaid) {
  servers_[1].render_tile = [](auto&, auto&, auto*) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "light_id = 7");
  };
  Tiles work(100);
  const auto report = run_job(work, options_);
  EXPECT_EQ(report.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(report.status().message()),
              HasSubstr(servers_[1].target() + ": light_id = 7"));
}

TEST_F(JobTest, ASceneThatCannotBeLoadedEndsIt) {
  servers_[0].load_scene = [](auto&, auto&, auto*) {
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "room.pbrt:1:1: what");
  };
  listed_.pop_back();
  Tiles work(1);
  EXPECT_THAT(run_job(work, options_).status().ToString(), HasSubstr("room.pbrt:1:1: what"));
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

TEST_F(JobTest, ServersOfOtherScenesEndIt) {
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

TEST_F(JobTest, ServersJoinAndLeaveWhileItRuns) {
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

TEST_F(JobTest, WaitsWhileNoServerAnswersAndSaysSo) {
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

TEST_F(JobTest, EndsWhenItIsToldTo) {
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

TEST_F(JobTest, AResultThatCannotBeKeptEndsIt) {
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

// A job on two servers whose answers the test decides.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "lucerna/client/job.h"
#include "tests/client/library/fake_server.h"

namespace lucerna::client {

/// Piece i requests a tile with seed i + 1 and takes the server's answer.
class Tiles final : public DistributedWork {
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

/// A gate at which calls wait.
class Door {
 public:
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    opened_.notify_all();
  }
  /// Waits until it is open, or the call is cancelled.
  void wait(grpc::ServerContext& context) {
    std::unique_lock lock(mutex_);
    while (!open_ && !context.IsCancelled()) opened_.wait_for(lock, std::chrono::milliseconds(10));
  }

 private:
  std::mutex mutex_;
  std::condition_variable opened_;
  bool open_ = false;
};

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
    options_.call = CallOptions::within(std::chrono::minutes(10));
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
  // A member of the fixture, since cancelled calls may wait here until the servers are gone.
  Door never_, door_;
  std::atomic<int> first_ = 0;
  std::map<FakeServer*, int> answers_;
  std::vector<std::string> listed_;
  std::vector<std::string> events_;
  FakeServer servers_[2];
  JobOptions options_;
};

}  // namespace lucerna::client

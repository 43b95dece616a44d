#include "client/library/query_servers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <mutex>
#include <thread>

#include "fake_server.h"
#include "google/rpc/status.pb.h"

namespace lucerna::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class QueryServersTest : public ::testing::Test {
 protected:
  QueryServersTest() {
    for (std::size_t i = 0; i < servers_.size(); ++i) {
      servers_[i].load_scene = [this, i](auto&, auto&, v1::LoadSceneResponse* response) {
        ++loads_[i];
        has_scene_[i] = true;
        response->set_scene_id(scenes_[i]);
        return grpc::Status::OK;
      };
      servers_[i].sample_li = [this, i](auto&, const v1::SampleLiRequest& request, auto*) {
        ++calls_[i];
        if (unavailable_[i]-- > 0) return grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining");
        if (!has_scene_[i] || request.scene_id() != scenes_[i]) {
          return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such scene");
        }
        return grpc::Status::OK;
      };
      targets_.push_back(servers_[i].target());
    }
    options_.servers = [this]() -> absl::StatusOr<std::vector<std::string>> { return targets_; };
    options_.load = [](const Client& client, const CallOptions& call) {
      return client.load_scene({}, call);
    };
    options_.call = CallOptions::within(std::chrono::minutes(10));
    options_.on_event = [this](const std::string& event) { events_.push_back(event); };
  }

  static std::array<int, 2> now(const std::array<std::atomic<int>, 2>& counts) {
    return {counts[0], counts[1]};
  }
  absl::Status sample(QueryServers& servers) {
    v1::SampleLiRequest request;
    request.set_scene_id(servers.scene_id());
    return servers
        .query([&](const Client& client) { return client.sample_li(request, options_.call); })
        .status();
  }
  /// Waits for the connections to all servers.
  void warm_up(QueryServers& servers) {
    for (int i = 0; i < 10'000 && (calls_[0] == 0 || calls_[1] == 0); ++i) {
      ASSERT_TRUE(sample(servers).ok());
    }
    ASSERT_GT(calls_[0], 0);
    ASSERT_GT(calls_[1], 0);
    calls_[0] = calls_[1] = 0;
  }

  std::array<FakeServer, 2> servers_;
  std::array<std::atomic<int>, 2> calls_{}, loads_{}, unavailable_{};
  std::array<std::atomic<bool>, 2> has_scene_{};
  std::array<std::string, 2> scenes_{"scene", "scene"};
  std::vector<std::string> targets_;
  std::vector<std::string> events_;
  QueryServersOptions options_;
};

TEST_F(QueryServersTest, CallsGoToTheServersInTurn) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  EXPECT_EQ(servers->scene_id(), "scene");
  EXPECT_THAT(now(loads_), ElementsAre(1, 1));
  warm_up(*servers);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(now(calls_), ElementsAre(10, 10));
  EXPECT_THAT(events_, IsEmpty());
}

TEST_F(QueryServersTest, CallsSurviveAServerThatStops) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  warm_up(*servers);
  const Client& client = servers->client();
  std::atomic<int> answered = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&] {
        v1::SampleLiRequest request;
        request.set_scene_id("scene");
        for (int j = 0; j < 200; ++j) {
          const absl::Status status = client.sample_li(request).status();
          EXPECT_TRUE(status.ok()) << status;
          answered += status.ok() ? 1 : 0;
        }
      });
    }
    while (answered < 200) std::this_thread::yield();
    servers_[0].server().Shutdown();  // after it has answered the calls in progress
  }
  EXPECT_EQ(answered, 8 * 200);
  calls_[0] = calls_[1] = 0;
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(now(calls_), ElementsAre(0, 20));
}

TEST_F(QueryServersTest, AnAbsentServerIsLeftOutAndReportedOnce) {
  targets_.emplace_back("127.0.0.1:1");
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  warm_up(*servers);
  has_scene_[0] = has_scene_[1] = false;
  EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(events_, ElementsAre(HasSubstr("127.0.0.1:1: ")));
}

TEST_F(QueryServersTest, UnavailableServersAreRetried) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  unavailable_[0] = unavailable_[1] = 1;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(now(loads_), ElementsAre(1, 1));
}

TEST_F(QueryServersTest, InterruptedQueriesAreRepeated) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  warm_up(*servers);
  // Errors of gRPC for calls to a server that is killed, at different moments.
  for (const auto code : {grpc::StatusCode::CANCELLED, grpc::StatusCode::UNKNOWN}) {
    int calls = 0;
    servers_[0].sample_li = servers_[1].sample_li = [&, code](auto&, auto&, auto*) {
      return ++calls == 1 ? grpc::Status(code, "gone") : grpc::Status::OK;
    };
    EXPECT_TRUE(sample(*servers).ok());
    EXPECT_EQ(calls, 2);
  }
  std::stop_source source;
  source.request_stop();
  options_.call.stop = source.get_token();
  EXPECT_EQ(QueryServers::connect(options_).status().code(), absl::StatusCode::kCancelled);
}

TEST_F(QueryServersTest, AServerThatLostTheSceneLoadsItAgain) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  warm_up(*servers);
  has_scene_[1] = false;  // as after a restart
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(now(loads_), ElementsAre(2, 2));
}

TEST_F(QueryServersTest, NotFoundOnAllServersIsAnError) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  scenes_ = {"other", "other"};
  v1::SampleLiRequest request;
  request.set_scene_id("no such");
  const auto answer =
      servers->query([&](const Client& client) { return client.sample_li(request); });
  // The scene's file has changed, which is another error than NOT_FOUND.
  EXPECT_EQ(answer.status().code(), absl::StatusCode::kFailedPrecondition);
  scenes_ = {"scene", "scene"};
  EXPECT_EQ(servers->query([&](const Client& client) { return client.sample_li(request); })
                .status()
                .code(),
            absl::StatusCode::kNotFound);
}

TEST_F(QueryServersTest, TheListIsReadAgainWhenAllServersAreGone) {
  targets_ = {servers_[0].target()};
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  servers_[0].server().Shutdown(std::chrono::system_clock::now());
  targets_ = {servers_[1].target()};
  EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(now(calls_), ElementsAre(0, 1));
}

TEST_F(QueryServersTest, DifferentFingerprintsAreNotMixedUnlessAllowed) {
  servers_[1].fingerprint = "g";
  const absl::Status status = QueryServers::connect(options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr(targets_[1]));
  EXPECT_THAT(std::string(status.message()), HasSubstr("fingerprint is g, that of " + targets_[0]));
  options_.allow_mixed = true;
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  EXPECT_THAT(servers->fingerprints(), ElementsAre("f", "g"));
  warm_up(*servers);
}

TEST_F(QueryServersTest, AServerThatReturnsAsAnotherBuildIsLeftOut) {
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  warm_up(*servers);
  has_scene_[0] = false;
  servers_[0].fingerprint = "g";
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(sample(*servers).ok());
  EXPECT_THAT(events_, ElementsAre(HasSubstr("continuing without")));
  EXPECT_THAT(servers->fingerprints(), ElementsAre("f"));
  EXPECT_EQ(calls_[0], 1);
}

TEST_F(QueryServersTest, ScenesMustBeTheSame) {
  scenes_[1] = "other";
  const absl::Status status = QueryServers::connect(options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("files differ"));
}

TEST_F(QueryServersTest, WithoutServersTheErrorOfOneIsReturned) {
  targets_ = {"127.0.0.1:1", servers_[0].target()};
  servers_[0].load_scene = [](auto&, auto&, auto*) {
    google::rpc::Status details;
    details.set_message("no such file");
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such file", details.SerializeAsString());
  };
  absl::Status status = QueryServers::connect(options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(std::string(status.message()), servers_[0].target() + ": no such file");
  EXPECT_TRUE(status.GetPayload(kStatusPayloadUrl).has_value());
  targets_ = {"127.0.0.1:1"};
  status = QueryServers::connect(options_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("127.0.0.1:1: "));
  targets_.clear();
  EXPECT_EQ(QueryServers::connect(options_).status().code(), absl::StatusCode::kUnavailable);
}

TEST_F(QueryServersTest, AddressesOfBothKindsAreOneList) {
  // The second server has the same address, written as IPv6.
  const std::string port = targets_[1].substr(targets_[1].rfind(':'));
  targets_[1] = "[::ffff:127.0.0.1]" + port;
  if (!Client::connect({.target = targets_[1]})->get_server_info().ok()) GTEST_SKIP() << "no IPv6";
  auto servers = QueryServers::connect(options_);
  ASSERT_TRUE(servers.ok()) << servers.status();
  warm_up(*servers);
}

}  // namespace
}  // namespace lucerna::client

#include "client/library/client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <stdexcept>
#include <thread>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "tests/client/library/fake_server.h"

namespace lucerna {
namespace {

using client::CallOptions;
using client::Client;
using ::testing::HasSubstr;
using ::testing::Not;

// Long enough that a passing test never waits this long.
constexpr std::chrono::minutes kBound{10};

/// Waits until the call is cancelled; true if it was.
bool wait_for_cancel(const grpc::ServerContext& context) {
  const auto end = std::chrono::steady_clock::now() + kBound;
  while (!context.IsCancelled() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return context.IsCancelled();
}

grpc::Status invalid(const std::string& message, const std::string& field,
                     const std::string& description) {
  google::rpc::BadRequest bad_request;
  auto* violation = bad_request.add_field_violations();
  violation->set_field(field);
  violation->set_description(description);
  google::rpc::Status details;
  details.set_code(3);
  details.set_message(message);
  details.add_details()->PackFrom(bad_request);
  return {grpc::StatusCode::INVALID_ARGUMENT, message, details.SerializeAsString()};
}

TEST(Client, TargetsWithoutAHostOrAPortAreRefused) {
  for (const char* target : {"", ":50051", "localhost", "[::1]", "::1:50051", "a:1,b:2"}) {
    const auto client = Client::connect({.target = target});
    EXPECT_EQ(client.status().code(), absl::StatusCode::kInvalidArgument) << target;
    EXPECT_THAT(std::string(client.status().message()), HasSubstr(", allowed: ")) << target;
  }
}

// gRPC takes ports modulo 65536: 119537 is 54001.
TEST(Client, PortsOfNoServerAreRefused) {
  FakeServer server;
  const std::string address = server.target();
  const std::string host = address.substr(0, address.rfind(':') + 1);
  const int port = std::stoi(address.substr(host.size()));
  for (const std::string& prefix : {"", "dns:///", "dns:", "ipv4:"}) {
    for (const std::string& text :
         {std::to_string(port + 65536), std::string("119537"), std::string("0"),
          std::string("65536"), std::string("-1"), std::string("99999999999999999999"),
          std::string("0x50"), std::string("http"), std::string("+80"), std::string()}) {
      const auto client = Client::connect({.target = prefix + host + text});
      EXPECT_EQ(client.status().message(),
                "target \"" + host + text + "\": port \"" + text + "\", allowed: 1 to 65535");
      EXPECT_EQ(client.status().code(), absl::StatusCode::kInvalidArgument);
    }
    EXPECT_TRUE(Client::connect({.target = prefix + address})->get_server_info().ok()) << prefix;
  }
  EXPECT_EQ(Client::connect({.target = "ipv6:[::1]:1,[::1]:119537"}).status().message(),
            "target \"[::1]:119537\": port \"119537\", allowed: 1 to 65535");
  for (const char* target : {"[::1]:65535", "unix:/run/lucernad", "unix:///run/lucernad"}) {
    EXPECT_TRUE(Client::connect({.target = target}).ok()) << target;
  }
}

TEST(Client, ServerThatCannotBeReachedIsUnavailable) {
  // No program listens on port 1 (tcpmux).
  const Client client = *Client::connect({.target = "127.0.0.1:1"});
  EXPECT_EQ(client.get_server_info().status().code(), absl::StatusCode::kUnavailable);
}

TEST(Client, EndsItsChannelItselfOnceItsLastCallIsAnswered) {
  std::optional<Client> client = *Client::connect({.target = "127.0.0.1:1", .retry = false});
  std::promise<absl::Status> answered;
  std::atomic<bool> ends = false, over = false;
  client->get_scene({}, {}, [&](const auto& answer) {
    answered.set_value(answer.status());
    ends.wait(false);
    for (int i = 0; i < 10'000; ++i) std::this_thread::yield();
    over = true;
  });
  EXPECT_EQ(answered.get_future().get().code(), absl::StatusCode::kUnavailable);
  ends = true;
  ends.notify_one();
  client.reset();
  // The end of the last channel waits for gRPC's answering threads, so it must not run in one of
  // them.
  EXPECT_TRUE(over);
}

TEST(Client, CarriesRequestAndResponse) {
  FakeServer server;
  server.get_scene = [](auto&, const v1::GetSceneRequest& request, v1::GetSceneResponse* response) {
    response->mutable_summary()->set_scene_id(request.scene_id() + "!");
    return grpc::Status::OK;
  };
  v1::GetSceneRequest request;
  request.set_scene_id("abc");
  const auto response = server.client().get_scene(request);
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->summary().scene_id(), "abc!");
}

TEST(Client, ErrorNamesTheInvalidFields) {
  FakeServer server;
  server.sample_li = [](auto&, const auto&, auto*) {
    return invalid("bad batch", "receivers.offsets_m", "4 numbers, must be three for each point");
  };
  const absl::Status status = server.client().sample_li({}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(std::string(status.message()),
            "bad batch; receivers.offsets_m: 4 numbers, must be three for each point");
  const auto payload = status.GetPayload(client::kStatusPayloadUrl);
  ASSERT_TRUE(payload.has_value());
  google::rpc::Status details;
  ASSERT_TRUE(details.ParseFromString(std::string(*payload)));
  EXPECT_EQ(details.message(), "bad batch");
}

TEST(Client, ErrorNamesAnInvalidFieldOnce) {
  FakeServer server;
  server.sample_li = [](auto&, const auto&, auto*) {
    return invalid("wi: 4 numbers, must be 3", "wi", "4 numbers, must be 3");
  };
  EXPECT_EQ(std::string(server.client().sample_li({}).status().message()),
            "wi: 4 numbers, must be 3");
}

TEST(Client, UnreadableDetailsLeaveTheErrorUnchanged) {
  FakeServer server;
  server.sample_li = [](auto&, const auto&, auto*) {
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such scene", "\xff\xff\xff");
  };
  const absl::Status status = server.client().sample_li({}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(std::string(status.message()), "no such scene");
}

TEST(Client, RetriesOnlyUnavailable) {
  FakeServer server;
  std::atomic<int> calls = 0;
  server.get_scene = [&](auto&, const auto&, auto*) {
    return ++calls < 3 ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining") : grpc::Status::OK;
  };
  EXPECT_TRUE(server.client().get_scene({}).ok());
  EXPECT_EQ(calls, 3);
  calls = 0;
  server.get_scene = [&](auto&, const auto&, auto*) {
    ++calls;
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "full");
  };
  EXPECT_EQ(server.client().get_scene({}).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(calls, 1);
}

TEST(Client, GivesUpOnUnavailableAfterFourAttempts) {
  FakeServer server;
  std::atomic<int> calls = 0;
  server.get_scene = [&](auto&, const auto&, auto*) {
    ++calls;
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining");
  };
  EXPECT_EQ(server.client().get_scene({}).status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(calls, 4);
}

TEST(Client, RetriesLargeRequestsToo) {
  FakeServer server;
  std::atomic<int> calls = 0;
  server.sample_li = [&](auto&, const auto&, auto*) {
    return ++calls == 1 ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining")
                        : grpc::Status::OK;
  };
  v1::SampleLiRequest request;  // more than gRPC's limit of 256 KiB
  request.mutable_receivers()->mutable_offsets_m()->Resize(500'000, 1);
  const absl::Status status = server.client().sample_li(request).status();
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(calls, 2);
}

TEST(Client, StopsRetryingWhileCallsKeepFailing) {
  FakeServer server;
  std::atomic<int> calls = 0;
  server.get_scene = [&](auto&, const auto&, auto*) {
    ++calls;
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining");
  };
  const Client client = server.client();
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 40; ++i) {
      threads.emplace_back([&] {
        for (int j = 0; j < 20; ++j) (void)client.get_scene({});
      });
    }
  }
  // 800 calls with four attempts each would be 3200.  The first 500 attempts leave half of the
  // tokens, forty are in progress, and from then on each call is one attempt.
  EXPECT_LT(calls, 500 + 40 + 800);
  EXPECT_GT(calls, 800);
}

TEST(Client, DeadlineEndsTheCall) {
  FakeServer server;
  server.get_scene = [](grpc::ServerContext& context, const auto&, auto*) {
    wait_for_cancel(context);
    return grpc::Status::OK;
  };
  const auto response =
      server.client().get_scene({}, CallOptions::within(std::chrono::milliseconds(50)));
  EXPECT_EQ(response.status().code(), absl::StatusCode::kDeadlineExceeded);
}

TEST(Client, DeadlinesBeyondTheClockAreNever) {
  FakeServer server;
  server.get_scene = [](auto&, const auto&, auto*) { return grpc::Status::OK; };
  for (const double seconds : {1e10, 1e18, 1e300}) {
    const CallOptions options = CallOptions::within(std::chrono::duration<double>(seconds));
    EXPECT_EQ(options.deadline, CallOptions::Clock::time_point::max()) << seconds;
    EXPECT_TRUE(server.client().get_scene({}, options).ok()) << seconds;
  }
  const auto passed = CallOptions::within(std::chrono::duration<double>(-1e300));
  EXPECT_EQ(server.client().get_scene({}, passed).status().code(),
            absl::StatusCode::kDeadlineExceeded);
}

TEST(Client, StopTokenEndsTheCallFromAnotherThread) {
  FakeServer server;
  std::promise<void> arrived;
  std::atomic<bool> cancelled = false;
  server.get_scene = [&](grpc::ServerContext& context, const auto&, auto*) {
    arrived.set_value();
    cancelled = wait_for_cancel(context);
    return grpc::Status::OK;
  };
  std::stop_source source;
  std::jthread other([&] {
    arrived.get_future().wait();
    source.request_stop();
  });
  CallOptions options;
  options.stop = source.get_token();
  const Client client = server.client();
  EXPECT_EQ(client.get_scene({}, options).status().code(), absl::StatusCode::kCancelled);
  other.join();
  server.server().Shutdown();  // waits for the handler
  EXPECT_TRUE(cancelled);
}

TEST(Client, StoppedBeforeTheCallIsCancelledAtOnce) {
  FakeServer server;
  std::stop_source source;
  source.request_stop();
  CallOptions options;
  options.stop = source.get_token();
  EXPECT_EQ(server.client().get_server_info({}, options).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(Client, TakesMessagesOfMoreThanFourMebibytes) {
  FakeServer server;
  server.render_tile = [](auto&, const auto&, v1::RenderTileResponse* response) {
    v1::Tile& tile = *response->mutable_tile();
    tile.mutable_rect()->set_x1(1 << 18);
    tile.mutable_rect()->set_y1(1);
    tile.set_image_width(1 << 18);
    tile.set_image_height(1);
    tile.set_block_count(1);
    tile.set_sum(std::string(6 << 20, '\0'));
    tile.set_deviation(tile.sum());
    return grpc::Status::OK;
  };
  const auto response = server.client().render_tile({});
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->tile().sum().size(), 6U << 20);
}

grpc::Status endless_tiles(grpc::ServerContext& context,
                           grpc::ServerWriter<v1::RenderImageResponse>& writer) {
  v1::RenderImageResponse response;
  while (!context.IsCancelled()) {
    response.set_samples_done(response.samples_done() + 1);
    if (!writer.Write(response)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return grpc::Status::CANCELLED;
}

TEST(Client, RenderImagePassesEachResponseInOrder) {
  FakeServer server;
  server.render_image = [](auto&, grpc::ServerWriter<v1::RenderImageResponse>& writer) {
    v1::RenderImageResponse response;
    v1::Tile& tile = *response.mutable_tile();
    tile.mutable_rect()->set_x1(1);
    tile.mutable_rect()->set_y1(1);
    tile.set_image_width(1);
    tile.set_image_height(1);
    tile.set_sum(std::string(24, '\0'));
    tile.set_deviation(tile.sum());
    for (int i = 1; i <= 3; ++i) {
      response.set_samples_done(i);
      tile.set_block_count(i);
      writer.Write(response);
    }
    return grpc::Status::OK;
  };
  std::vector<std::uint64_t> seen;
  const absl::Status status = server.client().render_image({}, [&](const auto& response) {
    seen.push_back(response.samples_done());
    return true;
  });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(seen, (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST(Client, RenderImageEndsWhenTheCallerStops) {
  FakeServer server;
  server.render_image = endless_tiles;
  int seen = 0;
  const absl::Status status =
      server.client().render_image({}, [&](const auto&) { return ++seen < 2; });
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(seen, 2);
  server.server().Shutdown();  // would wait forever for a handler that was not cancelled
}

TEST(Client, RenderImagePassesExceptionsOfTheCaller) {
  FakeServer server;
  server.render_image = endless_tiles;
  EXPECT_THROW((void)server.client().render_image(
                   {}, [](const auto&) -> bool { throw std::runtime_error("caller"); }),
               std::runtime_error);
  server.server().Shutdown();
}

TEST(Client, RenderImageReturnsTheServersError) {
  FakeServer server;
  server.render_image = [](auto&, auto&) {
    return invalid("bad size", "tile_size", "0, must be at least 1");
  };
  const absl::Status status = server.client().render_image({}, [](const auto&) { return true; });
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("tile_size"));
}

TEST(Client, HealthFollowsTheServer) {
  FakeServer server;
  const Client client = server.client();
  EXPECT_TRUE(client.check_health().ok());
  server.server().GetHealthCheckService()->SetServingStatus(false);
  const absl::Status status = client.check_health();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("NOT_SERVING"));
}

TEST(Client, AnswersManyThreadsAtOnce) {
  FakeServer server;
  server.get_scene = [](auto&, const v1::GetSceneRequest& request, v1::GetSceneResponse* response) {
    response->mutable_summary()->set_scene_id(request.scene_id());
    return grpc::Status::OK;
  };
  const Client client = server.client();
  std::atomic<int> right = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&, i] {
        v1::GetSceneRequest request;
        request.set_scene_id(std::to_string(i));
        for (int j = 0; j < 50; ++j) {
          const auto response = client.get_scene(request);
          if (response.ok() && response->summary().scene_id() == request.scene_id()) ++right;
        }
      });
    }
  }
  EXPECT_EQ(right, 8 * 50);
}

}  // namespace
}  // namespace lucerna

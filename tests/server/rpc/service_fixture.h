// A server within the test's process, and stubs that call it over loopback.
#pragma once

#include <google/rpc/error_details.pb.h>
#include <google/rpc/status.pb.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <future>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "lucerna/v1/admin.grpc.pb.h"
#include "lucerna/v1/lighting.grpc.pb.h"
#include "lucerna/v1/render.grpc.pb.h"
#include "lucerna/v1/scene.grpc.pb.h"
#include "server/rpc/server.h"
#include "server/store/scene_store.h"
#include "tests/paths.h"

namespace lucerna::testing {

inline rpc::ServerOptions service_options() {
  rpc::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.scenes.root = test_data("reference");
  options.version = "test";
  options.lanes.threads = 2;
  return options;
}

/// The same with the scenes in tests/data/pbrt.
inline rpc::ServerOptions pbrt_options() {
  rpc::ServerOptions options = service_options();
  options.scenes.root = test_data("pbrt");
  return options;
}

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// One running server with all stubs.
struct Service {
  explicit Service(const rpc::ServerOptions& options = service_options())
      : server(rpc::Server::start(options).value()),
        channel(grpc::CreateCustomChannel(server->address(), grpc::InsecureChannelCredentials(),
                                          arguments())),
        scenes(channel),
        lighting(channel),
        render(channel),
        admin(channel) {}

  std::string load(const std::string& path) {
    grpc::ClientContext context;
    v1::LoadSceneRequest request;
    request.set_path(path);
    v1::LoadSceneResponse response;
    const grpc::Status s = scenes.LoadScene(&context, request, &response);
    EXPECT_TRUE(s.ok()) << s.error_message();
    return response.scene_id();
  }

  static grpc::ChannelArguments arguments() {
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
    return arguments;
  }

  std::unique_ptr<rpc::Server> server;
  std::shared_ptr<grpc::Channel> channel;
  v1::SceneService::Stub scenes;
  v1::LightingService::Stub lighting;
  v1::RenderService::Stub render;
  v1::AdminService::Stub admin;
};

/// The status that `call(&context)` returns.
template <typename Call>
grpc::Status status_of(Call&& call) {
  grpc::ClientContext context;
  return call(&context);
}

/// The detail of one kind in an error; empty if there is none.
template <typename Detail>
Detail detail(const grpc::Status& status) {
  google::rpc::Status wire;
  Detail found;
  if (!wire.ParseFromString(status.error_details())) return found;
  for (const auto& any : wire.details()) {
    if (any.Is<Detail>()) any.UnpackTo(&found);
  }
  return found;
}

/// Checks an INVALID_ARGUMENT that names `field`, in its text and in its details.
inline void expect_bad_field(const grpc::Status& status, const std::string& field) {
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
  EXPECT_NE(status.error_message().find(field + " = "), std::string::npos)
      << status.error_message();
  const auto bad = detail<google::rpc::BadRequest>(status);
  ASSERT_EQ(bad.field_violations_size(), 1);
  EXPECT_EQ(bad.field_violations(0).field(), field);
  EXPECT_NE(bad.field_violations(0).description().find("allowed: "), std::string::npos);
  EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).domain(), "lucerna");
}

/// Keeps both threads of a lane busy until it is destroyed.
class BusyLane {
 public:
  BusyLane(rpc::Server& server, Lane lane) {
    // A load answers shortly before its job ends.
    while (server.lanes().pending(lane) > 0) std::this_thread::yield();
    const std::shared_future<void> opened = open_.get_future().share();
    for (int i = 0; i < 2; ++i) {
      std::promise<void> begun;
      EXPECT_TRUE(server.lanes()
                      .submit(lane, {.run =
                                         [&begun, opened](const LaneJobStart&) {
                                           begun.set_value();
                                           opened.wait();
                                         },
                                     .client = "ipv4:127.0.0.1"})  // as the calls of these tests
                      .ok());
      begun.get_future().wait();
    }
  }
  ~BusyLane() { open_.set_value(); }

 private:
  std::promise<void> open_;
};

template <typename... Numbers>
void set(google::protobuf::RepeatedField<float>* field, Numbers... numbers) {
  field->Clear();
  (field->Add(static_cast<float>(numbers)), ...);
}

}  // namespace lucerna::testing

// A server within the test's process, and stubs that call it over loopback.
#pragma once

#include <google/rpc/error_details.pb.h>
#include <google/rpc/status.pb.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <future>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

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

/// The same with another root of scenes.
inline rpc::ServerOptions scenes_in(const std::filesystem::path& root) {
  rpc::ServerOptions options = service_options();
  options.scenes.root = root.string();
  return options;
}

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A unary call of the contract.
template <auto kMethod>
struct UnaryCall;
template <typename Service, typename Question, typename Answer,
          grpc::Status (Service::*kMethod)(grpc::ClientContext*, const Question&, Answer*)>
struct UnaryCall<kMethod> {
  using Stub = Service;
  using Response = Answer;
  static constexpr auto kSend = kMethod;
  static UnaryCall of(const Question&);
};
template <typename... Calls>
struct UnaryCalls : Calls... {
  using Calls::of...;
};
using Scenes = v1::SceneService::Stub;
using Lighting = v1::LightingService::Stub;
using Rendering = v1::RenderService::Stub;
using Admin = v1::AdminService::Stub;

/// RenderImage, whose response stands for all messages, in order.
struct ImageCall {
  using Response = std::vector<v1::RenderImageResponse>;
  static ImageCall of(const v1::RenderImageRequest&);
};

/// The call that takes these requests.
template <typename Request>
using CallFor =
    decltype(UnaryCalls<ImageCall, UnaryCall<&Scenes::FindMissingAssets>,
                        UnaryCall<&Scenes::LoadScene>, UnaryCall<&Scenes::EditLights>,
                        UnaryCall<&Scenes::GetScene>, UnaryCall<&Scenes::ListScenes>,
                        UnaryCall<&Scenes::ListAvailableScenes>, UnaryCall<&Scenes::ListLights>,
                        UnaryCall<&Scenes::RenewLease>, UnaryCall<&Scenes::ReleaseScene>,
                        UnaryCall<&Lighting::SampleLi>, UnaryCall<&Lighting::PdfLi>,
                        UnaryCall<&Lighting::SampleLe>, UnaryCall<&Lighting::PdfLe>,
                        UnaryCall<&Lighting::Le>, UnaryCall<&Lighting::EstimatePower>,
                        UnaryCall<&Lighting::TestVisibility>,
                        UnaryCall<&Lighting::EstimateIrradiance>, UnaryCall<&Rendering::RenderTile>,
                        UnaryCall<&Rendering::FindSurfaces>, UnaryCall<&Admin::GetServerInfo>,
                        UnaryCall<&Admin::GetStats>,
                        UnaryCall<&Admin::ListLeases>>::of(std::declval<Request>()));
template <typename Request>
using ResponseTo = typename CallFor<Request>::Response;

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

  template <typename Request>
  grpc::Status call(grpc::ClientContext* context, const Request& request,
                    ResponseTo<Request>* response) {
    using Call = CallFor<Request>;
    auto& stub = std::get<typename Call::Stub&>(std::tie(scenes, lighting, render, admin));
    return (stub.*Call::kSend)(context, request, response);
  }
  template <typename Request>
  grpc::Status call(const Request& request, ResponseTo<Request>* response) {
    grpc::ClientContext context;
    return call(&context, request, response);
  }
  template <typename Request>
  grpc::Status status(const Request& request) {
    ResponseTo<Request> response;
    return call(request, &response);
  }
  /// The answer to a call that must succeed.
  template <typename Request>
  ResponseTo<Request> answer(const Request& request) {
    ResponseTo<Request> response;
    const grpc::Status status = call(request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  grpc::Status call(grpc::ClientContext* context, const v1::RenderImageRequest& request,
                    std::vector<v1::RenderImageResponse>* sent) {
    const auto reader = render.RenderImage(context, request);
    for (v1::RenderImageResponse r; reader->Read(&r);) sent->push_back(r);
    return reader->Finish();
  }

  std::string load(const std::string& path) {
    v1::LoadSceneRequest request;
    request.set_path(path);
    return answer(request).scene_id();
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
  Scenes scenes;
  Lighting lighting;
  Rendering render;
  Admin admin;
};

/// A request about a scene.
template <typename Request>
Request about(const std::string& scene) {
  Request q;
  q.set_scene_id(scene);
  return q;
}

/// Pixels [x0, x1) x [y0, y1).
inline void set_rect(v1::RenderTileRequest* q, std::uint32_t x0, std::uint32_t y0, std::uint32_t x1,
                     std::uint32_t y1) {
  q->mutable_rect()->set_x0(x0);
  q->mutable_rect()->set_y0(y0);
  q->mutable_rect()->set_x1(x1);
  q->mutable_rect()->set_y1(y1);
}
inline void set_rect(v1::RenderTileRequest* q, std::uint32_t width, std::uint32_t height) {
  set_rect(q, 0, 0, width, height);
}

/// The mean over all numbers of a tile.
inline double mean_of(const v1::Tile& tile) {
  double sum = 0;
  const std::size_t n = tile.sum().size() / sizeof(double);
  for (std::size_t i = 0; i < n; ++i) {
    double v = 0;
    std::memcpy(&v, tile.sum().data() + i * sizeof v, sizeof v);
    sum += v / static_cast<double>(tile.block_count());
  }
  return sum / static_cast<double>(n);
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

/// Checks the code of an error, a part of its text, and its reason.
inline void expect_error(const grpc::Status& status, grpc::StatusCode code,
                         const std::string& words, const std::string& reason = "") {
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  EXPECT_NE(status.error_message().find(words), std::string::npos) << status.error_message();
  if (!reason.empty()) {
    EXPECT_EQ(detail<google::rpc::ErrorInfo>(status).reason(), reason);
  }
}

/// A change that makes a valid request invalid, and the field that the error must name.
template <typename Request>
struct BadField {
  std::string field;
  std::function<void(Request&)> change;
};

template <typename Request>
void expect_bad_fields(Service& service, const Request& valid,
                       const std::vector<BadField<Request>>& rows) {
  for (const BadField<Request>& row : rows) {
    SCOPED_TRACE(row.field);
    Request q = valid;
    row.change(q);
    expect_bad_field(service.status(q), row.field);
  }
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

template <typename Message>
std::string without_cost(Message message) {
  message.clear_cost();
  return message.SerializeAsString();
}

}  // namespace lucerna::testing

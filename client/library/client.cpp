#include "client/library/client.h"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <future>
#include <optional>
#include <utility>

#include "client/library/answer_checks.h"
#include "client/library/call_context.h"
#include "client/library/channel.h"
#include "client/library/status.h"
#include "grpc/health/v1/health.pb.h"
#include "lucerna/v1/admin.grpc.pb.h"
#include "lucerna/v1/lighting.grpc.pb.h"
#include "lucerna/v1/render.grpc.pb.h"
#include "lucerna/v1/scene.grpc.pb.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

/// Makes one blocking call of a generated stub.
template <class Service, class Request, class Response>
absl::StatusOr<Response> call(const std::unique_ptr<Service>& service,
                              grpc::Status (Service::*method)(grpc::ClientContext*, const Request&,
                                                              Response*),
                              const Request& request, const CallOptions& options) {
  // gRPC looks at the clock now and then, so the answer may come first.
  if (options.deadline <= CallOptions::Clock::now())
    return absl::DeadlineExceededError("the deadline had passed before the call");
  CallContext context(options);
  Response response;
  const grpc::Status status = (*service.*method)(context.get(), request, &response);
  if (!status.ok()) return to_absl_status(status);
  LUCERNA_RETURN_IF_ERROR(check_answer(request, response));
  return response;
}

/// Begins one call of a generated stub.
template <class Async, class Request, class Response>
void begin(Async* service,
           void (Async::*method)(grpc::ClientContext*, const Request*, Response*,
                                 std::function<void(grpc::Status)>),
           const Request& request, const CallOptions& options, Client::Done<Response> done) {
  struct State {
    State(const Request& r, const CallOptions& options)
        : request(r), context(std::in_place, options) {}
    Request request;
    Response response;
    std::optional<CallContext> context;
  };
  const auto state = std::make_shared<State>(request, options);
  (service->*method)(state->context->get(), &state->request, &state->response,
                     [state, done = std::move(done)](const grpc::Status& status) {
                       // The context keeps the channel alive, so destroy it before `done` is
                       // called.  Otherwise, if the client is destroyed meanwhile, this thread of
                       // gRPC destroys the channel.  gRPC 1.51 then joins the thread from within
                       // itself, and the process aborts.
                       state->context.reset();
                       const absl::Status checked =
                           status.ok() ? check_answer(state->request, state->response)
                                       : to_absl_status(status);
                       if (checked.ok()) {
                         done(std::move(state->response));
                       } else {
                         done(checked);
                       }
                     });
}

}  // namespace

CallOptions CallOptions::within(std::chrono::duration<double> time) {
  const Clock::time_point now = Clock::now();
  // Beyond the end of the clock is never.
  if (time >= Clock::time_point::max() - now) return {};
  const std::chrono::duration<double> left = std::max(time, std::chrono::duration<double>(0));
  return {.deadline = now + std::chrono::duration_cast<Clock::duration>(left), .stop = {}};
}

CallOptions CallOptions::at_most(std::chrono::duration<double> time) const {
  return {.deadline = std::min(deadline, within(time).deadline), .stop = stop};
}

class Client::Connection {
 public:
  Connection(std::string target, const std::shared_ptr<grpc::Channel>& channel)
      : target(std::move(target)),
        scene(v1::SceneService::NewStub(channel)),
        lighting(v1::LightingService::NewStub(channel)),
        render(v1::RenderService::NewStub(channel)),
        admin(v1::AdminService::NewStub(channel)),
        channel(channel) {}

  const std::string target;
  // Stub interfaces, since pointers to their methods are not ambiguous.
  const std::unique_ptr<v1::SceneService::StubInterface> scene;
  const std::unique_ptr<v1::LightingService::StubInterface> lighting;
  const std::unique_ptr<v1::RenderService::StubInterface> render;
  const std::unique_ptr<v1::AdminService::StubInterface> admin;
  const std::shared_ptr<grpc::Channel> channel;
};

Client::Client(std::shared_ptr<const Connection> connection) : connection_(std::move(connection)) {}

absl::StatusOr<Client> Client::connect(const ConnectOptions& options) {
  auto channel = make_channel(options);
  if (!channel.ok()) return channel.status();
  return Client(std::make_shared<Connection>(options.target, *std::move(channel)));
}

const std::string& Client::target() const { return connection_->target; }

absl::StatusOr<v1::FindMissingAssetsResponse> Client::find_missing_assets(
    const v1::FindMissingAssetsRequest& request, const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::FindMissingAssets, request,
              options);
}

absl::StatusOr<v1::UploadAssetResponse> Client::upload_asset(
    const v1::AssetHeader& header, const std::function<bool(std::string&)>& next_chunk,
    const CallOptions& options) const {
  CallContext context(options);
  v1::UploadAssetResponse response;
  // The destructor also runs if next_chunk throws.  A writer must not be destroyed during its call.
  struct Writer {
    CallContext& context;
    std::unique_ptr<grpc::ClientWriterInterface<v1::UploadAssetRequest>> stream;
    bool finished = false;

    grpc::Status finish() {
      finished = true;
      return stream->Finish();
    }
    ~Writer() {
      if (finished) return;
      context.cancel();
      stream->Finish();
    }
  } writer{context, connection_->scene->UploadAsset(context.get(), &response)};

  v1::UploadAssetRequest request;
  *request.mutable_header() = header;
  bool open = writer.stream->Write(request);
  // A failed write means that the call has ended.  Finish() returns its status.
  while (open && next_chunk(*request.mutable_chunk())) open = writer.stream->Write(request);
  if (open) writer.stream->WritesDone();
  const grpc::Status status = writer.finish();
  if (!status.ok()) return to_absl_status(status);
  return response;
}

absl::StatusOr<v1::LoadSceneResponse> Client::load_scene(const v1::LoadSceneRequest& request,
                                                         const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::LoadScene, request, options);
}

absl::StatusOr<v1::EditLightsResponse> Client::edit_lights(const v1::EditLightsRequest& request,
                                                           const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::EditLights, request, options);
}

absl::StatusOr<v1::GetSceneResponse> Client::get_scene(const v1::GetSceneRequest& request,
                                                       const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::GetScene, request, options);
}

void Client::get_scene(const v1::GetSceneRequest& request, const CallOptions& options,
                       Done<v1::GetSceneResponse> done) const {
  begin(connection_->scene->async(), &v1::SceneService::StubInterface::async_interface::GetScene,
        request, options, std::move(done));
}

absl::StatusOr<v1::ListScenesResponse> Client::list_scenes(const v1::ListScenesRequest& request,
                                                           const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::ListScenes, request, options);
}

absl::StatusOr<v1::ListAvailableScenesResponse> Client::list_available_scenes(
    const v1::ListAvailableScenesRequest& request, const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::ListAvailableScenes, request,
              options);
}

absl::StatusOr<v1::ListLightsResponse> Client::list_lights(const v1::ListLightsRequest& request,
                                                           const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::ListLights, request, options);
}

absl::StatusOr<v1::RenewLeaseResponse> Client::renew_lease(const v1::RenewLeaseRequest& request,
                                                           const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::RenewLease, request, options);
}

void Client::renew_lease(const v1::RenewLeaseRequest& request, const CallOptions& options,
                         Done<v1::RenewLeaseResponse> done) const {
  begin(connection_->scene->async(), &v1::SceneService::StubInterface::async_interface::RenewLease,
        request, options, std::move(done));
}

absl::StatusOr<v1::ReleaseSceneResponse> Client::release_scene(
    const v1::ReleaseSceneRequest& request, const CallOptions& options) const {
  return call(connection_->scene, &v1::SceneService::StubInterface::ReleaseScene, request, options);
}

absl::StatusOr<v1::SampleLiResponse> Client::sample_li(const v1::SampleLiRequest& request,
                                                       const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::SampleLi, request,
              options);
}

absl::StatusOr<v1::PdfLiResponse> Client::pdf_li(const v1::PdfLiRequest& request,
                                                 const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::PdfLi, request, options);
}

absl::StatusOr<v1::SampleLeResponse> Client::sample_le(const v1::SampleLeRequest& request,
                                                       const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::SampleLe, request,
              options);
}

absl::StatusOr<v1::PdfLeResponse> Client::pdf_le(const v1::PdfLeRequest& request,
                                                 const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::PdfLe, request, options);
}

absl::StatusOr<v1::LeResponse> Client::le(const v1::LeRequest& request,
                                          const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::Le, request, options);
}

absl::StatusOr<v1::EstimatePowerResponse> Client::estimate_power(
    const v1::EstimatePowerRequest& request, const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::EstimatePower, request,
              options);
}

absl::StatusOr<v1::TestVisibilityResponse> Client::test_visibility(
    const v1::TestVisibilityRequest& request, const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::TestVisibility, request,
              options);
}

absl::StatusOr<v1::EstimateIrradianceResponse> Client::estimate_irradiance(
    const v1::EstimateIrradianceRequest& request, const CallOptions& options) const {
  return call(connection_->lighting, &v1::LightingService::StubInterface::EstimateIrradiance,
              request, options);
}

void Client::estimate_irradiance(const v1::EstimateIrradianceRequest& request,
                                 const CallOptions& options,
                                 Done<v1::EstimateIrradianceResponse> done) const {
  begin(connection_->lighting->async(),
        &v1::LightingService::StubInterface::async_interface::EstimateIrradiance, request, options,
        std::move(done));
}

absl::StatusOr<v1::RenderTileResponse> Client::render_tile(const v1::RenderTileRequest& request,
                                                           const CallOptions& options) const {
  return call(connection_->render, &v1::RenderService::StubInterface::RenderTile, request, options);
}

void Client::render_tile(const v1::RenderTileRequest& request, const CallOptions& options,
                         Done<v1::RenderTileResponse> done) const {
  begin(connection_->render->async(),
        &v1::RenderService::StubInterface::async_interface::RenderTile, request, options,
        std::move(done));
}

absl::Status Client::render_image(
    const v1::RenderImageRequest& request,
    const std::function<bool(const v1::RenderImageResponse&)>& on_response,
    const CallOptions& options) const {
  CallContext context(options);
  // The destructor also runs if on_response throws.  A reader must not be destroyed during its
  // call.
  struct Reader {
    CallContext& context;
    std::unique_ptr<grpc::ClientReaderInterface<v1::RenderImageResponse>> stream;
    bool finished = false;

    grpc::Status finish() {
      finished = true;
      return stream->Finish();
    }
    ~Reader() {
      if (finished) return;
      context.cancel();
      stream->Finish();
    }
  } reader{context, connection_->render->RenderImage(context.get(), request)};

  v1::RenderImageResponse response;
  ImageCheck check;
  while (reader.stream->Read(&response)) {
    if (absl::Status s = check.add(response); !s.ok()) {
      context.cancel();
      reader.finish();
      return s;
    }
    if (on_response(response)) continue;
    context.cancel();
    reader.finish();
    return absl::CancelledError("the caller stopped the picture");
  }
  const grpc::Status status = reader.finish();
  return status.ok() ? check.end() : to_absl_status(status);
}

absl::StatusOr<v1::FindSurfacesResponse> Client::find_surfaces(
    const v1::FindSurfacesRequest& request, const CallOptions& options) const {
  return call(connection_->render, &v1::RenderService::StubInterface::FindSurfaces, request,
              options);
}

absl::StatusOr<v1::ListLeasesResponse> Client::list_leases(const v1::ListLeasesRequest& request,
                                                           const CallOptions& options) const {
  return call(connection_->admin, &v1::AdminService::StubInterface::ListLeases, request, options);
}

absl::StatusOr<v1::GetServerInfoResponse> Client::get_server_info(
    const v1::GetServerInfoRequest& request, const CallOptions& options) const {
  return call(connection_->admin, &v1::AdminService::StubInterface::GetServerInfo, request,
              options);
}

absl::StatusOr<v1::GetStatsResponse> Client::get_stats(const v1::GetStatsRequest& request,
                                                       const CallOptions& options) const {
  return call(connection_->admin, &v1::AdminService::StubInterface::GetStats, request, options);
}

absl::Status Client::check_health(const CallOptions& options) const {
  using grpc::health::v1::HealthCheckRequest;
  using grpc::health::v1::HealthCheckResponse;
  CallContext context(options);
  grpc::TemplatedGenericStub<HealthCheckRequest, HealthCheckResponse> stub(connection_->channel);
  const HealthCheckRequest request;
  HealthCheckResponse response;
  // Shared, because the callback's thread may still be inside set_value() when this thread
  // continues.
  const auto done = std::make_shared<std::promise<grpc::Status>>();
  stub.UnaryCall(context.get(), "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [done](grpc::Status status) { done->set_value(std::move(status)); });
  const grpc::Status status = done->get_future().get();
  if (!status.ok()) return to_absl_status(status);
  if (response.status() != HealthCheckResponse::SERVING) {
    return absl::UnavailableError("the server runs but does not serve: " +
                                  HealthCheckResponse::ServingStatus_Name(response.status()));
  }
  return absl::OkStatus();
}

}  // namespace lucerna::client

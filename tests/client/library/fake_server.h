// A server in this process whose answers the test decides.
#pragma once

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "client/library/batch_parts.h"
#include "lucerna/client/client.h"
#include "lucerna/v1/admin.grpc.pb.h"
#include "lucerna/v1/lighting.grpc.pb.h"
#include "lucerna/v1/render.grpc.pb.h"
#include "lucerna/v1/scene.grpc.pb.h"

namespace lucerna {

/// Each call invokes the function of its name.
class FakeServer : v1::LightingService::Service,
                   v1::SceneService::Service,
                   v1::RenderService::Service,
                   v1::AdminService::Service {
 public:
  template <class Request, class Response>
  using Handler = std::function<grpc::Status(grpc::ServerContext&, const Request&, Response*)>;

  Handler<v1::SampleLiRequest, v1::SampleLiResponse> sample_li;
  Handler<v1::SampleLeRequest, v1::SampleLeResponse> sample_le;
  Handler<v1::EstimateIrradianceRequest, v1::EstimateIrradianceResponse> irradiance;
  Handler<v1::GetSceneRequest, v1::GetSceneResponse> get_scene;
  Handler<v1::RenderTileRequest, v1::RenderTileResponse> render_tile;
  Handler<v1::LoadSceneRequest, v1::LoadSceneResponse> load_scene;
  Handler<v1::RenewLeaseRequest, v1::RenewLeaseResponse> renew_lease;
  Handler<v1::ReleaseSceneRequest, v1::ReleaseSceneResponse> release_scene;
  Handler<v1::FindMissingAssetsRequest, v1::FindMissingAssetsResponse> find_missing_assets;
  std::function<grpc::Status(grpc::ServerReader<v1::UploadAssetRequest>&, v1::UploadAssetResponse*)>
      upload_asset;
  std::function<grpc::Status(grpc::ServerContext&, grpc::ServerWriter<v1::RenderImageResponse>&)>
      render_image;
  /// Fills arrays that a handler leaves empty with zeros, so that tests set only what they read.
  bool completes_answers = true;
  std::uint32_t max_batch_items = 5;
  std::uint64_t max_message_bytes = 64 << 20;
  std::string fingerprint = "f";
  std::atomic<int> info_calls = 0;

  FakeServer() {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(static_cast<v1::LightingService::Service*>(this));
    builder.RegisterService(static_cast<v1::SceneService::Service*>(this));
    builder.RegisterService(static_cast<v1::RenderService::Service*>(this));
    builder.RegisterService(static_cast<v1::AdminService::Service*>(this));
    server_ = builder.BuildAndStart();
  }

  client::Client client() const { return *client::Client::connect({.target = target()}); }
  std::string target() const { return "127.0.0.1:" + std::to_string(port_); }
  grpc::Server& server() { return *server_; }

 private:
  grpc::Status SampleLi(grpc::ServerContext* context, const v1::SampleLiRequest* request,
                        v1::SampleLiResponse* response) override {
    const grpc::Status status = sample_li(*context, *request, response);
    if (completes_answers && status.ok()) complete(*request, *response);
    return status;
  }
  grpc::Status SampleLe(grpc::ServerContext* context, const v1::SampleLeRequest* request,
                        v1::SampleLeResponse* response) override {
    const grpc::Status status = sample_le(*context, *request, response);
    if (completes_answers && status.ok()) complete(*request, *response);
    return status;
  }
  grpc::Status EstimateIrradiance(grpc::ServerContext* context,
                                  const v1::EstimateIrradianceRequest* request,
                                  v1::EstimateIrradianceResponse* response) override {
    const grpc::Status status = irradiance(*context, *request, response);
    if (completes_answers && status.ok()) complete(*request, *response);
    return status;
  }
  grpc::Status GetScene(grpc::ServerContext* context, const v1::GetSceneRequest* request,
                        v1::GetSceneResponse* response) override {
    return get_scene(*context, *request, response);
  }
  grpc::Status LoadScene(grpc::ServerContext* context, const v1::LoadSceneRequest* request,
                         v1::LoadSceneResponse* response) override {
    return load_scene(*context, *request, response);
  }
  grpc::Status RenewLease(grpc::ServerContext* context, const v1::RenewLeaseRequest* request,
                          v1::RenewLeaseResponse* response) override {
    return renew_lease(*context, *request, response);
  }
  grpc::Status ReleaseScene(grpc::ServerContext* context, const v1::ReleaseSceneRequest* request,
                            v1::ReleaseSceneResponse* response) override {
    return release_scene(*context, *request, response);
  }
  grpc::Status FindMissingAssets(grpc::ServerContext* context,
                                 const v1::FindMissingAssetsRequest* request,
                                 v1::FindMissingAssetsResponse* response) override {
    return find_missing_assets(*context, *request, response);
  }
  grpc::Status UploadAsset(grpc::ServerContext*, grpc::ServerReader<v1::UploadAssetRequest>* reader,
                           v1::UploadAssetResponse* response) override {
    return upload_asset(*reader, response);
  }
  grpc::Status RenderTile(grpc::ServerContext* context, const v1::RenderTileRequest* request,
                          v1::RenderTileResponse* response) override {
    const grpc::Status status = render_tile(*context, *request, response);
    if (completes_answers && status.ok() && !response->tile().has_rect())
      complete(*request, *response->mutable_tile());
    return status;
  }
  grpc::Status RenderImage(grpc::ServerContext* context, const v1::RenderImageRequest*,
                           grpc::ServerWriter<v1::RenderImageResponse>* writer) override {
    return render_image(*context, *writer);
  }
  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse* response) override {
    ++info_calls;
    response->mutable_limits()->set_max_batch_items(max_batch_items);
    response->mutable_limits()->set_max_samples(1 << 20);
    response->mutable_limits()->set_max_message_bytes(max_message_bytes);
    response->mutable_fingerprint()->set_digest(fingerprint);
    return grpc::Status::OK;
  }

  /// A black tile.
  static void complete(const v1::RenderTileRequest& request, v1::Tile& tile) {
    *tile.mutable_rect() = request.rect();
    if (!request.has_rect()) {
      tile.mutable_rect()->set_x1(1);
      tile.mutable_rect()->set_y1(1);
    }
    const v1::PixelRect& rect = tile.rect();
    tile.set_image_width(rect.x1());
    tile.set_image_height(rect.y1());
    const std::uint32_t length = std::max(1U, request.samples_per_block());
    tile.set_samples_per_block(length);
    tile.set_first_block(request.first_sample() / length);
    tile.set_block_count(std::max(1U, request.accuracy().samples() / length));
    tile.set_sum(std::string(24UL * (rect.x1() - rect.x0()) * (rect.y1() - rect.y0()), '\0'));
    tile.set_deviation(tile.sum());
  }
  template <class T>
  static void fill(std::size_t count, google::protobuf::RepeatedField<T>* array) {
    if (array->empty()) array->Resize(static_cast<int>(count), T{});
  }
  static void complete(const v1::SampleLiRequest& request, v1::SampleLiResponse& response) {
    const std::size_t receivers = client::item_count(request);
    std::size_t n = receivers * std::max(1U, request.accuracy().samples());
    if (request.accuracy().has_target_error() || request.accuracy().has_time_budget_s()) {
      v1::ReceiverEstimates& e = *response.mutable_estimates();
      if (e.samples().empty()) e.mutable_samples()->Resize(static_cast<int>(receivers), 1);
      for (auto* array : {e.mutable_illuminance_lx(), e.mutable_standard_error_lx(),
                          e.mutable_lower_lx(), e.mutable_upper_lx()})
        fill(receivers, array);
      n = 0;
      for (const std::uint32_t samples : e.samples()) n += samples;
    }
    for (auto* array : {response.mutable_value(), response.mutable_wi(),
                        response.mutable_light_offsets_m(), response.mutable_light_normals()})
      fill(3 * n, array);
    for (auto* array : {response.mutable_distance_m(), response.mutable_pdf_per_sr()})
      fill(n, array);
    fill(n * request.wavelengths_nm_size(), response.mutable_spectral_value());
    if (!request.has_light_id() && request.light_name().empty()) {
      fill(n, response.mutable_light_ids());
      fill(n, response.mutable_selection_probability());
    }
    if (request.test_visibility()) response.mutable_visible()->resize((n + 7) / 8);
  }
  static void complete(const v1::SampleLeRequest& request, v1::SampleLeResponse& response) {
    const std::size_t n = request.count();
    for (auto* array :
         {response.mutable_points()->mutable_offsets_m(), response.mutable_directions(),
          response.mutable_light_normals(), response.mutable_value()})
      fill(3 * n, array);
    fill(n, response.mutable_pdf_position_per_m2());
    fill(n, response.mutable_pdf_direction_per_sr());
    fill(n * request.wavelengths_nm_size(), response.mutable_spectral_value());
    if (!request.has_light_id() && request.light_name().empty()) {
      fill(n, response.mutable_light_ids());
      fill(n, response.mutable_selection_probability());
    }
  }
  static void complete(const v1::EstimateIrradianceRequest& request,
                       v1::EstimateIrradianceResponse& response) {
    const std::size_t n = client::item_count(request);
    fill(3 * n, response.mutable_irradiance_lx());
    fill(n, response.mutable_illuminance_lx());
    fill(n, response.mutable_zero_bound_lx());
    fill(response.lower_lx_size(), response.mutable_upper_lx());
    fill(n * request.wavelengths_nm_size(), response.mutable_spectral_irradiance());
    if (request.accuracy().has_target_error()) {
      fill(n, response.mutable_lower_lx());
      fill(n, response.mutable_upper_lx());
      fill(n, response.mutable_item_costs()->mutable_samples());
    }
    for (v1::LightShare& share : *response.mutable_shares()) {
      fill(n, share.mutable_illuminance_lx());
      fill(share.lower_lx_size(), share.mutable_upper_lx());
    }
  }

  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace lucerna

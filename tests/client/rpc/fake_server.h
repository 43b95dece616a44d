// A server in this process whose answers the test decides.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

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
    return sample_li(*context, *request, response);
  }
  grpc::Status SampleLe(grpc::ServerContext* context, const v1::SampleLeRequest* request,
                        v1::SampleLeResponse* response) override {
    return sample_le(*context, *request, response);
  }
  grpc::Status EstimateIrradiance(grpc::ServerContext* context,
                                  const v1::EstimateIrradianceRequest* request,
                                  v1::EstimateIrradianceResponse* response) override {
    return irradiance(*context, *request, response);
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
    return render_tile(*context, *request, response);
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

  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace lucerna

#include "server/rpc/services.h"

#include "lucerna/v1/admin.grpc.pb.h"
#include "lucerna/v1/lighting.grpc.pb.h"
#include "lucerna/v1/render.grpc.pb.h"
#include "lucerna/v1/scene.grpc.pb.h"
#include "server/access/calls.h"
#include "server/rpc/call.h"
#include "server/rpc/handlers/light_edits.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/handlers/scenes.h"
#include "server/rpc/handlers/tiles.h"
#include "server/rpc/image_stream.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/upload_stream.h"

namespace lucerna::rpc {
namespace {

using access::Call;
using CallContext = grpc::CallbackServerContext;
using Unary = grpc::ServerUnaryReactor;

class SceneServiceImpl final : public v1::SceneService::CallbackService {
 public:
  explicit SceneServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* LoadScene(CallContext* context, const v1::LoadSceneRequest* request,
                   v1::LoadSceneResponse* response) override {
    return UnaryCall::start(runtime_, Call::kLoadScene, context,
                            [&](const Context& c) { return load_scene(c, *request, response); });
  }
  Unary* GetScene(CallContext* context, const v1::GetSceneRequest* request,
                  v1::GetSceneResponse* response) override {
    return UnaryCall::start(runtime_, Call::kGetScene, context,
                            [&](const Context& c) { return get_scene(c, *request, response); });
  }
  Unary* ListScenes(CallContext* context, const v1::ListScenesRequest* request,
                    v1::ListScenesResponse* response) override {
    return UnaryCall::start(runtime_, Call::kListScenes, context,
                            [&](const Context& c) { return list_scenes(c, *request, response); });
  }
  Unary* ListAvailableScenes(CallContext* context, const v1::ListAvailableScenesRequest* request,
                             v1::ListAvailableScenesResponse* response) override {
    return UnaryCall::start(runtime_, Call::kListAvailableScenes, context, [&](const Context& c) {
      return list_available_scenes(c, *request, response);
    });
  }
  Unary* ListLights(CallContext* context, const v1::ListLightsRequest* request,
                    v1::ListLightsResponse* response) override {
    return UnaryCall::start(runtime_, Call::kListLights, context,
                            [&](const Context& c) { return list_lights(c, *request, response); });
  }
  Unary* ReleaseScene(CallContext* context, const v1::ReleaseSceneRequest* request,
                      v1::ReleaseSceneResponse* response) override {
    return UnaryCall::start(runtime_, Call::kReleaseScene, context,
                            [&](const Context& c) { return release_scene(c, *request, response); });
  }

  Unary* FindMissingAssets(CallContext* context, const v1::FindMissingAssetsRequest* request,
                           v1::FindMissingAssetsResponse* response) override {
    return UnaryCall::start(runtime_, Call::kFindMissingAssets, context, [&](const Context& c) {
      return find_missing_assets(c, *request, response);
    });
  }
  grpc::ServerReadReactor<v1::UploadAssetRequest>* UploadAsset(
      CallContext* context, v1::UploadAssetResponse* response) override {
    return UploadStream::start(runtime_, context, response);
  }
  Unary* RenewLease(CallContext* context, const v1::RenewLeaseRequest* request,
                    v1::RenewLeaseResponse* response) override {
    return UnaryCall::start(runtime_, Call::kRenewLease, context,
                            [&](const Context& c) { return renew_lease(c, *request, response); });
  }

  Unary* EditLights(CallContext* context, const v1::EditLightsRequest* request,
                    v1::EditLightsResponse* response) override {
    return UnaryCall::start(runtime_, Call::kEditLights, context,
                            [&](const Context& c) { return edit_lights(c, *request, response); });
  }

 private:
  Runtime& runtime_;
};

class LightingServiceImpl final : public v1::LightingService::CallbackService {
 public:
  explicit LightingServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* SampleLi(CallContext* context, const v1::SampleLiRequest* request,
                  v1::SampleLiResponse* response) override {
    return UnaryCall::start(runtime_, Call::kSampleLi, context,
                            [&](const Context& c) { return sample_li(c, *request, response); });
  }
  Unary* PdfLi(CallContext* context, const v1::PdfLiRequest* request,
               v1::PdfLiResponse* response) override {
    return UnaryCall::start(runtime_, Call::kPdfLi, context,
                            [&](const Context& c) { return pdf_li(c, *request, response); });
  }
  Unary* EstimatePower(CallContext* context, const v1::EstimatePowerRequest* request,
                       v1::EstimatePowerResponse* response) override {
    return UnaryCall::start(runtime_, Call::kEstimatePower, context, [&](const Context& c) {
      return estimate_power(c, *request, response);
    });
  }
  Unary* TestVisibility(CallContext* context, const v1::TestVisibilityRequest* request,
                        v1::TestVisibilityResponse* response) override {
    return UnaryCall::start(runtime_, Call::kTestVisibility, context, [&](const Context& c) {
      return test_visibility(c, *request, response);
    });
  }
  Unary* EstimateIrradiance(CallContext* context, const v1::EstimateIrradianceRequest* request,
                            v1::EstimateIrradianceResponse* response) override {
    return UnaryCall::start(runtime_, Call::kEstimateIrradiance, context, [&](const Context& c) {
      return estimate_irradiance(c, *request, response);
    });
  }

  Unary* SampleLe(CallContext* context, const v1::SampleLeRequest* request,
                  v1::SampleLeResponse* response) override {
    return UnaryCall::start(runtime_, Call::kSampleLe, context,
                            [&](const Context& c) { return sample_le(c, *request, response); });
  }
  Unary* PdfLe(CallContext* context, const v1::PdfLeRequest* request,
               v1::PdfLeResponse* response) override {
    return UnaryCall::start(runtime_, Call::kPdfLe, context,
                            [&](const Context& c) { return pdf_le(c, *request, response); });
  }
  Unary* Le(CallContext* context, const v1::LeRequest* request, v1::LeResponse* response) override {
    return UnaryCall::start(runtime_, Call::kLe, context,
                            [&](const Context& c) { return le(c, *request, response); });
  }

 private:
  Runtime& runtime_;
};

class RenderServiceImpl final : public v1::RenderService::CallbackService {
 public:
  explicit RenderServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* RenderTile(CallContext* context, const v1::RenderTileRequest* request,
                    v1::RenderTileResponse* response) override {
    return UnaryCall::start(runtime_, Call::kRenderTile, context,
                            [&](const Context& c) { return render_tile(c, *request, response); });
  }
  grpc::ServerWriteReactor<v1::RenderImageResponse>* RenderImage(
      CallContext* context, const v1::RenderImageRequest* request) override {
    return ImageStream::start(runtime_, context, *request);
  }

 private:
  Runtime& runtime_;
};

class AdminServiceImpl final : public v1::AdminService::CallbackService {
 public:
  explicit AdminServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* GetServerInfo(CallContext* context, const v1::GetServerInfoRequest*,
                       v1::GetServerInfoResponse* response) override {
    return UnaryCall::start(runtime_, Call::kGetServerInfo, context,
                            [&](const Context&) -> Prepared {
                              Task task;
                              task.run = [&runtime = runtime_, response](const std::stop_token&) {
                                const std::lock_guard lock(runtime.info_mutex);
                                *response = runtime.info;
                                return absl::OkStatus();
                              };
                              return task;
                            });
  }
  Unary* GetStats(CallContext* context, const v1::GetStatsRequest*,
                  v1::GetStatsResponse*) override {
    return UnaryCall::start(runtime_, Call::kGetStats, context, [](const Context&) -> Prepared {
      return unimplemented("the server keeps no statistics yet; each answer has a cost");
    });
  }
  Unary* ListLeases(CallContext* context, const v1::ListLeasesRequest* request,
                    v1::ListLeasesResponse* response) override {
    return UnaryCall::start(runtime_, Call::kListLeases, context,
                            [&](const Context& c) { return list_leases(c, *request, response); });
  }

 private:
  Runtime& runtime_;
};

}  // namespace

std::vector<std::string> service_names() {
  return {v1::SceneService::service_full_name(), v1::LightingService::service_full_name(),
          v1::RenderService::service_full_name(), v1::AdminService::service_full_name()};
}

std::vector<std::unique_ptr<grpc::Service>> make_services(Runtime& runtime) {
  std::vector<std::unique_ptr<grpc::Service>> services;
  services.push_back(std::make_unique<SceneServiceImpl>(runtime));
  services.push_back(std::make_unique<LightingServiceImpl>(runtime));
  services.push_back(std::make_unique<RenderServiceImpl>(runtime));
  services.push_back(std::make_unique<AdminServiceImpl>(runtime));
  return services;
}

}  // namespace lucerna::rpc

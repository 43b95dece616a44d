#include "server/rpc/services.h"

#include "lucerna/v1/admin.grpc.pb.h"
#include "lucerna/v1/lighting.grpc.pb.h"
#include "lucerna/v1/render.grpc.pb.h"
#include "lucerna/v1/scene.grpc.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/handlers/light_edits.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/handlers/scenes.h"
#include "server/rpc/handlers/surfaces.h"
#include "server/rpc/handlers/tiles.h"
#include "server/rpc/image_stream.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/stats.h"
#include "server/rpc/upload_stream.h"

namespace lucerna::rpc {
namespace {

using CallContext = grpc::CallbackServerContext;
using Unary = grpc::ServerUnaryReactor;
using Bytes = grpc::ByteBuffer;
using monitor::Call;

/// Starts a call whose handler needs nothing but the context.
template <typename Request, typename Response>
Unary* unary(Runtime& runtime, CallContext* context, Call call, const Bytes* request,
             Bytes* response, Prepared (*handler)(const Context&, const Request&, Response*)) {
  return TypedCall<Request, Response>::start(runtime, context, call, request, response, handler);
}

// gRPC's generated classes give a service the bytes of its calls.  One class for each call.

using SceneBase = v1::SceneService::WithRawCallbackMethod_FindMissingAssets<
    v1::SceneService::WithRawCallbackMethod_UploadAsset<
        v1::SceneService::WithRawCallbackMethod_LoadScene<
            v1::SceneService::WithRawCallbackMethod_GetScene<
                v1::SceneService::WithRawCallbackMethod_ListScenes<
                    v1::SceneService::WithRawCallbackMethod_ListAvailableScenes<
                        v1::SceneService::WithRawCallbackMethod_ListLights<
                            v1::SceneService::WithRawCallbackMethod_EditLights<
                                v1::SceneService::WithRawCallbackMethod_RenewLease<
                                    v1::SceneService::WithRawCallbackMethod_ReleaseScene<
                                        v1::SceneService::Service>>>>>>>>>>;
using LightingBase = v1::LightingService::WithRawCallbackMethod_SampleLi<
    v1::LightingService::WithRawCallbackMethod_PdfLi<
        v1::LightingService::WithRawCallbackMethod_SampleLe<
            v1::LightingService::WithRawCallbackMethod_PdfLe<
                v1::LightingService::WithRawCallbackMethod_Le<
                    v1::LightingService::WithRawCallbackMethod_EstimatePower<
                        v1::LightingService::WithRawCallbackMethod_TestVisibility<
                            v1::LightingService::WithRawCallbackMethod_EstimateIrradiance<
                                v1::LightingService::Service>>>>>>>>;
using RenderBase = v1::RenderService::WithRawCallbackMethod_RenderTile<
    v1::RenderService::WithRawCallbackMethod_RenderImage<
        v1::RenderService::WithRawCallbackMethod_FindSurfaces<v1::RenderService::Service>>>;
using AdminBase = v1::AdminService::WithRawCallbackMethod_GetServerInfo<
    v1::AdminService::WithRawCallbackMethod_GetStats<
        v1::AdminService::WithRawCallbackMethod_ListLeases<v1::AdminService::Service>>>;

class SceneServiceImpl final : public SceneBase {
 public:
  explicit SceneServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* FindMissingAssets(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kFindMissingAssets, request, response,
                 &find_missing_assets);
  }
  grpc::ServerReadReactor<Bytes>* UploadAsset(CallContext* context, Bytes* response) override {
    return UploadStream::start(runtime_, context, response);
  }
  Unary* LoadScene(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kLoadScene, request, response, &load_scene);
  }
  Unary* GetScene(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kGetScene, request, response, &get_scene);
  }
  Unary* ListScenes(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kListScenes, request, response, &list_scenes);
  }
  Unary* ListAvailableScenes(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kListAvailableScenes, request, response,
                 &list_available_scenes);
  }
  Unary* ListLights(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kListLights, request, response, &list_lights);
  }
  Unary* EditLights(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kEditLights, request, response, &edit_lights);
  }
  Unary* RenewLease(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kRenewLease, request, response, &renew_lease);
  }
  Unary* ReleaseScene(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kReleaseScene, request, response, &release_scene);
  }

 private:
  Runtime& runtime_;
};

class LightingServiceImpl final : public LightingBase {
 public:
  explicit LightingServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* SampleLi(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kSampleLi, request, response, &sample_li);
  }
  Unary* PdfLi(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kPdfLi, request, response, &pdf_li);
  }
  Unary* SampleLe(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kSampleLe, request, response, &sample_le);
  }
  Unary* PdfLe(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kPdfLe, request, response, &pdf_le);
  }
  Unary* Le(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kLe, request, response, &le);
  }
  Unary* EstimatePower(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kEstimatePower, request, response, &estimate_power);
  }
  Unary* TestVisibility(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kTestVisibility, request, response, &test_visibility);
  }
  Unary* EstimateIrradiance(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kEstimateIrradiance, request, response,
                 &estimate_irradiance);
  }

 private:
  Runtime& runtime_;
};

class RenderServiceImpl final : public RenderBase {
 public:
  explicit RenderServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* RenderTile(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kRenderTile, request, response, &render_tile);
  }
  grpc::ServerWriteReactor<Bytes>* RenderImage(CallContext* context,
                                               const Bytes* request) override {
    return ImageStream::start(runtime_, context, request);
  }
  Unary* FindSurfaces(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kFindSurfaces, request, response, &find_surfaces);
  }

 private:
  Runtime& runtime_;
};

class AdminServiceImpl final : public AdminBase {
 public:
  explicit AdminServiceImpl(Runtime& runtime) : runtime_(runtime) {}

  Unary* GetServerInfo(CallContext* context, const Bytes* request, Bytes* response) override {
    return TypedCall<v1::GetServerInfoRequest, v1::GetServerInfoResponse>::start(
        runtime_, context, Call::kGetServerInfo, request, response,
        [&runtime = runtime_](const Context&, const v1::GetServerInfoRequest&,
                              v1::GetServerInfoResponse* answer) -> Prepared {
          Task task;
          task.run = [&runtime, answer](const std::stop_token&) {
            const std::lock_guard lock(runtime.info_mutex);
            *answer = runtime.info;
            return absl::OkStatus();
          };
          return task;
        });
  }
  Unary* GetStats(CallContext* context, const Bytes* request, Bytes* response) override {
    return TypedCall<v1::GetStatsRequest, v1::GetStatsResponse>::start(
        runtime_, context, Call::kGetStats, request, response,
        [&runtime = runtime_](const Context&, const v1::GetStatsRequest&,
                              v1::GetStatsResponse* answer) -> Prepared {
          Task task;
          task.run = [&runtime, answer](const std::stop_token&) {
            set_stats(figures(runtime), answer);
            return absl::OkStatus();
          };
          return task;
        });
  }
  Unary* ListLeases(CallContext* context, const Bytes* request, Bytes* response) override {
    return unary(runtime_, context, Call::kListLeases, request, response, &list_leases);
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

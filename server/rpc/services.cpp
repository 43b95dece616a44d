#include "server/rpc/services.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "server/rpc/call.h"
#include "server/rpc/handlers/edit_lights_handler.h"
#include "server/rpc/handlers/estimate_irradiance_handler.h"
#include "server/rpc/handlers/estimate_power_handler.h"
#include "server/rpc/handlers/find_missing_assets_handler.h"
#include "server/rpc/handlers/find_surfaces_handler.h"
#include "server/rpc/handlers/get_scene_handler.h"
#include "server/rpc/handlers/le_handler.h"
#include "server/rpc/handlers/lease_handlers.h"
#include "server/rpc/handlers/list_handlers.h"
#include "server/rpc/handlers/load_scene_handler.h"
#include "server/rpc/handlers/pdf_handlers.h"
#include "server/rpc/handlers/render_tile_handler.h"
#include "server/rpc/handlers/sample_le_handler.h"
#include "server/rpc/handlers/sample_li_handler.h"
#include "server/rpc/handlers/test_visibility_handler.h"
#include "server/rpc/health.h"
#include "server/rpc/image_stream.h"
#include "server/rpc/reflection.h"
#include "server/rpc/stats.h"
#include "server/rpc/upload_stream.h"

namespace lucerna::rpc {
namespace {

using monitor::Call;

/// A call that does not exist.
class UnknownCall final : public Reactor {
 public:
  using Reactor::Reactor;

 private:
  void begin() override { finish(absl::UnimplementedError("the server has no such call")); }
  void take(bool) override {}
};

struct CallHandler {
  Call call;
  Reactor* (*start)(Runtime&, grpc::CallbackServerContext&, Call);
};

/// Begins a call that `handler` answers.
template <auto handler>
constexpr auto unary = Reactor::start<TypedCall<handler>>;

/// What answers each call, in the order of Call: a function from a request, or a class for a
/// stream.  The function predicts the time of the work, which chooses its lane.
constexpr CallHandler kHandlers[] = {
    {Call::kFindMissingAssets, unary<handle_find_missing_assets>},
    {Call::kUploadAsset, Reactor::start<UploadStream>},
    {Call::kLoadScene, unary<handle_load_scene>},
    {Call::kGetScene, unary<handle_get_scene>},
    {Call::kListScenes, unary<handle_list_scenes>},
    {Call::kListAvailableScenes, unary<handle_list_available_scenes>},
    {Call::kListLights, unary<handle_list_lights>},
    {Call::kEditLights, unary<handle_edit_lights>},
    {Call::kRenewLease, unary<handle_renew_lease>},
    {Call::kReleaseScene, unary<handle_release_scene>},
    {Call::kSampleLi, unary<handle_sample_li>},
    {Call::kPdfLi, unary<handle_pdf_li>},
    {Call::kSampleLe, unary<handle_sample_le>},
    {Call::kPdfLe, unary<handle_pdf_le>},
    {Call::kLe, unary<handle_le>},
    {Call::kEstimatePower, unary<handle_estimate_power>},
    {Call::kTestVisibility, unary<handle_test_visibility>},
    {Call::kEstimateIrradiance, unary<handle_estimate_irradiance>},
    {Call::kRenderTile, unary<handle_render_tile>},
    {Call::kRenderImage, Reactor::start<ImageStream>},
    {Call::kGetServerInfo, unary<handle_get_server_info>},
    {Call::kGetStats, unary<handle_get_stats>},
    {Call::kListLeases, unary<handle_list_leases>},
    {Call::kFindSurfaces, unary<handle_find_surfaces>},
    {Call::kHealthCheck, Reactor::start<HealthCheck>},
    {Call::kHealthWatch, Reactor::start<HealthWatch>},
    {Call::kReflection, Reactor::start<Reflection>},
    {Call::kUnknown, Reactor::start<UnknownCall>},
};
static_assert(
    [] {
      for (std::size_t i = 0; i < monitor::kCalls; ++i)
        if (kHandlers[i].call != static_cast<Call>(i)) return false;
      return std::size(kHandlers) == monitor::kCalls;
    }(),
    "kHandlers has each call once, in the order of Call");

/// The handler of a method of gRPC: "/" and the name of a call.
const CallHandler& handler_of(const std::string& method) {
  static const auto all = [] {
    std::unordered_map<std::string, const CallHandler*> handlers;
    for (const CallHandler& handler : kHandlers)
      handlers[fmt::format("/{}", monitor::name_of(handler.call))] = &handler;
    handlers["/grpc.reflection.v1.ServerReflection/ServerReflectionInfo"] =
        &kHandlers[static_cast<std::size_t>(Call::kReflection)];
    return handlers;
  }();
  const auto found = all.find(method);
  return found == all.end() ? kHandlers[monitor::kCalls - 1] : *found->second;
}

/// Generated services would begin a call when its message has arrived.  Nobody could count or end
/// the calls that wait for theirs.
class AllCalls final : public grpc::CallbackGenericService {
 public:
  explicit AllCalls(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    const CallHandler& handler = handler_of(context->method());
    return handler.start(runtime_, *context, handler.call);
  }

 private:
  Runtime& runtime_;
};

}  // namespace

std::vector<std::string> service_names() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < static_cast<std::size_t>(Call::kUnknown); ++i) {
    const std::string call = monitor::name_of(static_cast<Call>(i));
    std::string service = call.substr(0, call.rfind('/'));
    if (std::ranges::count(names, service) == 0) names.push_back(std::move(service));
  }
  return names;
}

std::unique_ptr<grpc::CallbackGenericService> make_service(Runtime& runtime) {
  return std::make_unique<AllCalls>(runtime);
}

}  // namespace lucerna::rpc

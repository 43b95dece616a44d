#include "server/rpc/services.h"

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <unordered_map>
#include <utility>

#include "lucerna/v1/admin.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/handlers/light_edits.h"
#include "server/rpc/handlers/lighting.h"
#include "server/rpc/handlers/scenes.h"
#include "server/rpc/handlers/surfaces.h"
#include "server/rpc/handlers/tiles.h"
#include "server/rpc/health.h"
#include "server/rpc/image_stream.h"
#include "server/rpc/messages/errors.h"
#include "server/rpc/reflection.h"
#include "server/rpc/stats.h"
#include "server/rpc/upload_stream.h"

namespace lucerna::rpc {
namespace {

using monitor::Call;
using Start = std::function<Reactor*(Runtime&, grpc::CallbackServerContext&, Call)>;

/// A call whose handler needs nothing but the context.
template <typename Request, typename Response>
Start unary(Prepared (*handler)(const Context&, const Request&, Response*)) {
  return [handler](Runtime& runtime, grpc::CallbackServerContext& context, Call call) {
    return Reactor::start<TypedCall<Request, Response>>(runtime, context, call, handler);
  };
}

/// A call that computes its answer from the server's state.
template <typename Request, typename Response>
Start of_runtime(void (*answer)(Runtime&, Response*)) {
  return [answer](Runtime& runtime, grpc::CallbackServerContext& context, Call call) {
    return Reactor::start<TypedCall<Request, Response>>(
        runtime, context, call,
        [answer, &runtime](const Context&, const Request&, Response* response) -> Prepared {
          Task task;
          task.run = [answer, &runtime, response](const std::stop_token&) {
            answer(runtime, response);
            return absl::OkStatus();
          };
          return task;
        });
  };
}

template <typename T>
Start stream() {
  return [](Runtime& runtime, grpc::CallbackServerContext& context, Call call) {
    return Reactor::start<T>(runtime, context, call);
  };
}

/// A call that does not exist.
class UnknownCall final : public Reactor {
 public:
  using Reactor::Reactor;

 private:
  void begin() override { finish(no_such_call()); }
  void take(bool) override {}
};

void get_server_info(Runtime& runtime, v1::GetServerInfoResponse* answer) {
  const std::lock_guard lock(runtime.info_mutex);
  *answer = runtime.info;
}

void get_stats(Runtime& runtime, v1::GetStatsResponse* answer) {
  set_stats(figures(runtime), answer);
}

struct Entry {
  Call call;
  Start start;
};

/// All calls, by "/" and their full name.
const std::unordered_map<std::string, Entry>& all_calls() {
  static const auto all = [] {
    std::unordered_map<std::string, Entry> calls;
    const auto add = [&](Call call, Start start) {
      calls[fmt::format("/{}", monitor::name_of(call))] = {call, std::move(start)};
    };
    add(Call::kFindMissingAssets, unary(&find_missing_assets));
    add(Call::kLoadScene, unary(&load_scene));
    add(Call::kGetScene, unary(&get_scene));
    add(Call::kListScenes, unary(&list_scenes));
    add(Call::kListAvailableScenes, unary(&list_available_scenes));
    add(Call::kListLights, unary(&list_lights));
    add(Call::kEditLights, unary(&edit_lights));
    add(Call::kRenewLease, unary(&renew_lease));
    add(Call::kReleaseScene, unary(&release_scene));
    add(Call::kSampleLi, unary(&sample_li));
    add(Call::kPdfLi, unary(&pdf_li));
    add(Call::kSampleLe, unary(&sample_le));
    add(Call::kPdfLe, unary(&pdf_le));
    add(Call::kLe, unary(&le));
    add(Call::kEstimatePower, unary(&estimate_power));
    add(Call::kTestVisibility, unary(&test_visibility));
    add(Call::kEstimateIrradiance, unary(&estimate_irradiance));
    add(Call::kRenderTile, unary(&render_tile));
    add(Call::kFindSurfaces, unary(&find_surfaces));
    add(Call::kListLeases, unary(&list_leases));
    add(Call::kGetServerInfo, of_runtime<v1::GetServerInfoRequest>(&get_server_info));
    add(Call::kGetStats, of_runtime<v1::GetStatsRequest>(&get_stats));
    add(Call::kUploadAsset, stream<UploadStream>());
    add(Call::kRenderImage, stream<ImageStream>());
    add(Call::kHealthCheck, stream<HealthCheck>());
    add(Call::kHealthWatch, stream<HealthWatch>());
    add(Call::kReflection, stream<Reflection>());
    calls["/grpc.reflection.v1.ServerReflection/ServerReflectionInfo"] = {Call::kReflection,
                                                                          stream<Reflection>()};
    return calls;
  }();
  return all;
}

/// Generated services would begin a call when its message has arrived.  Nobody could count or end
/// the calls that wait for theirs.
class AllCalls final : public grpc::CallbackGenericService {
 public:
  explicit AllCalls(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerGenericBidiReactor* CreateReactor(
      grpc::GenericCallbackServerContext* context) override {
    const auto found = all_calls().find(context->method());
    if (found != all_calls().end())
      return found->second.start(runtime_, *context, found->second.call);
    return Reactor::start<UnknownCall>(runtime_, *context, Call::kUnknown);
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

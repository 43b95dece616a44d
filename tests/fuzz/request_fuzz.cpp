// Reads the input as a request.  Its first byte chooses the call by its number (monitor::Call), and
// the others are the bytes of the message.  The handler of the call then answers it.  For
// UploadAsset, the bytes are messages, each after its length in one byte.
//
// In a message, the scene "S" stands for the id of a loaded scene, and the lease "L" for its lease.
#include <grpcpp/grpcpp.h>
#include <tbb/task_arena.h>

#include <cstdlib>
#include <iostream>
#include <limits>
#include <string>

#include "lucerna/v1/admin.pb.h"
#include "lucerna/v1/lighting.pb.h"
#include "lucerna/v1/render.pb.h"
#include "lucerna/v1/scene.grpc.pb.h"
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
#include "server/rpc/handlers/render_image_handler.h"
#include "server/rpc/handlers/render_tile_handler.h"
#include "server/rpc/handlers/sample_le_handler.h"
#include "server/rpc/handlers/sample_li_handler.h"
#include "server/rpc/handlers/test_visibility_handler.h"
#include "server/rpc/observed_call.h"
#include "server/rpc/services.h"
#include "tests/fuzz/input_files.h"
#include "tests/paths.h"

namespace lucerna::fuzz {
namespace {

using monitor::Call;
using rpc::CallContext;
using rpc::Prepared;

constexpr char kScene[] = "lights/every_light.pbrt";
// Manifests of inputs name this file by its digest.
constexpr std::string_view kAsset = "WorldBegin LightSource \"point\"\n";
// A few bytes can ask for any number of samples.  A longer answer is not computed.
constexpr double kMostSeconds = 0.01;
constexpr double kLeaseSeconds = 1e6;

template <typename T>
T checked(absl::StatusOr<T> value) {
  if (value.ok()) return *std::move(value);
  std::cerr << value.status() << "\n";
  std::abort();
}

void check(const absl::Status& status) {
  // The request cannot be the reason of an internal error.
  if (!absl::IsInternal(status) && !absl::IsUnknown(status)) return;
  std::cerr << status << "\n";
  std::abort();
}

SceneStoreOptions store_options() {
  constexpr std::uint64_t kMemoryBytes = std::uint64_t{64} << 20;
  SceneStoreOptions options;
  options.root = test_data();
  options.memory_budget_bytes = kMemoryBytes;
  options.load.max_texels = 1 << 16;
  options.load.max_primitives = 20000;
  options.load.max_scene_bytes = 1 << 22;
  options.load.max_tokens = 1 << 16;
  return options;
}

rpc::RequestLimits request_limits() {
  return {.max_batch_items = 64,
          .max_tile_pixels = 64,
          .max_samples = 16,
          .max_page_size = 8,
          .max_name_bytes = 256,
          .max_message_bytes = 1 << 20};
}

/// A server without connections.
class World {
 public:
  World() : lanes_({.threads = 1}), runtime_(lanes_) {
    rpc::set_up_protobuf_log();
    runtime_.limits.set(request_limits());
    runtime_.assets = checked(AssetStore::open({.max_asset_bytes = 256, .budget_bytes = 4096}));
    AssetUpload upload = checked(runtime_.assets->upload(sha256(kAsset), kAsset.size(), 0));
    if (!upload.append(kAsset).ok() || !upload.finish().ok()) std::abort();
    runtime_.scenes = checked(SceneStore::open(store_options(), runtime_.assets.get()));
    load();
  }

  void answer(Call call, std::string_view bytes) {
    if (call == Call::kUploadAsset) return upload(bytes);
    arena_.execute([&] { answer_here(call, bytes); });
    tidy();
  }

 private:
  void load() {
    arena_.execute([&] {
      const LoadedScene loaded = checked(runtime_.scenes->load(kScene, {.lease_s = kLeaseSeconds}));
      scene_ = loaded.stored.scene->id();
      lease_ = loaded.lease.id;
    });
  }

  /// Leaves one scene with one lease, so that no input depends on those before it.
  void tidy() {
    constexpr std::size_t kAll = 1000;
    SceneStore& scenes = *runtime_.scenes;
    bool kept = false;
    for (const ListedLease& lease : scenes.leases({}, "", kAll)) {
      kept |= lease.id == lease_;
      if (lease.id != lease_) static_cast<void>(scenes.release(lease.scene_id, lease.id));
    }
    for (const StoredScene& stored : scenes.list("", kAll))
      if (stored.scene->id() != scene_) static_cast<void>(scenes.release(stored.scene->id()));
    if (!kept || scenes.find(scene_) == nullptr) load();
  }

  /// Replaces "S" and "L".
  template <typename Request>
  void complete(Request& request) const {
    if constexpr (requires { request.set_scene_id(""); })
      if (request.scene_id() == "S") request.set_scene_id(scene_);
    if constexpr (requires { request.set_lease_id(""); })
      if (request.lease_id() == "L") request.set_lease_id(lease_);
  }

  template <typename Request>
  bool parse(std::string_view bytes, Request& request) const {
    const grpc::Slice slice(bytes.data(), bytes.size());
    const absl::Status status = rpc::parse_message(grpc::ByteBuffer(&slice, 1), request);
    check(status);
    complete(request);
    return status.ok();
  }

  template <typename Request, typename Response>
  void run(std::string_view bytes,
           Prepared (*handler)(const CallContext&, const Request&, Response*),
           double most_s = kMostSeconds) {
    Request request;
    Response response;
    if (!parse(bytes, request)) return;
    const Prepared task = handler(runtime_.context({}), request, &response);
    check(task.status());
    if (!task.ok() || task->predicted_s > most_s) return;
    const absl::Status status = task->run({});
    check(status);
    grpc::ByteBuffer answer;
    if (status.ok()) check(rpc::encode_message(response, answer));
  }

  void render_image(std::string_view bytes) {
    constexpr int kSteps = 2;
    v1::RenderImageRequest request;
    if (!parse(bytes, request)) return;
    auto render = rpc::RenderImageHandler::create(runtime_.context({}), request);
    check(render.status());
    for (int step = 0; render.ok() && step < kSteps && !render->done(); ++step) {
      v1::RenderImageResponse response;
      const absl::Status status = render->next({}, &response);
      check(status);
      if (!status.ok()) return;
    }
  }

  void answer_here(Call call, std::string_view bytes) {
    constexpr double kAny = std::numeric_limits<double>::infinity();
    switch (call) {
      case Call::kFindMissingAssets:
        return run(bytes, &rpc::handle_find_missing_assets);
      case Call::kLoadScene:
        return run(bytes, &rpc::handle_load_scene, kAny);
      case Call::kGetScene:
        return run(bytes, &rpc::handle_get_scene);
      case Call::kListScenes:
        return run(bytes, &rpc::handle_list_scenes);
      case Call::kListAvailableScenes:
        return run(bytes, &rpc::handle_list_available_scenes, kAny);
      case Call::kListLights:
        return run(bytes, &rpc::handle_list_lights);
      case Call::kEditLights:
        return run(bytes, &rpc::handle_edit_lights, kAny);
      case Call::kRenewLease:
        return run(bytes, &rpc::handle_renew_lease);
      case Call::kReleaseScene:
        return run(bytes, &rpc::handle_release_scene, kAny);
      case Call::kSampleLi:
        return run(bytes, &rpc::handle_sample_li);
      case Call::kPdfLi:
        return run(bytes, &rpc::handle_pdf_li);
      case Call::kSampleLe:
        return run(bytes, &rpc::handle_sample_le);
      case Call::kPdfLe:
        return run(bytes, &rpc::handle_pdf_le);
      case Call::kLe:
        return run(bytes, &rpc::handle_le);
      case Call::kEstimatePower:
        return run(bytes, &rpc::handle_estimate_power);
      case Call::kTestVisibility:
        return run(bytes, &rpc::handle_test_visibility);
      case Call::kEstimateIrradiance:
        return run(bytes, &rpc::handle_estimate_irradiance);
      case Call::kRenderTile:
        return run(bytes, &rpc::handle_render_tile);
      case Call::kRenderImage:
        return render_image(bytes);
      case Call::kListLeases:
        return run(bytes, &rpc::handle_list_leases);
      case Call::kFindSurfaces:
        return run(bytes, &rpc::handle_find_surfaces);
      // Their requests have no fields.
      case Call::kGetServerInfo: {
        v1::GetServerInfoRequest request;
        parse(bytes, request);
        return;
      }
      case Call::kGetStats: {
        v1::GetStatsRequest request;
        parse(bytes, request);
        return;
      }
      case Call::kUploadAsset:
        return;  // see upload()
      // No message reaches them.
      case Call::kHealthCheck:
      case Call::kHealthWatch:
      case Call::kReflection:
      case Call::kUnknown:
        return;
    }
  }

  /// Sends the messages to a server in this process.  Only the stream of gRPC answers them.  gRPC's
  /// channel within a process cannot be used: a client that writes after the answer waits for ever.
  void upload(std::string_view bytes) {
    if (server_ == nullptr) {
      service_ = rpc::make_service(runtime_);
      grpc::ServerBuilder builder;
      builder.RegisterCallbackGenericService(service_.get());
      int port = 0;
      builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
      server_ = builder.BuildAndStart();
      if (server_ == nullptr) std::abort();
      stub_ = v1::SceneService::NewStub(grpc::CreateChannel("127.0.0.1:" + std::to_string(port),
                                                            grpc::InsecureChannelCredentials()));
    }
    grpc::ClientContext context;
    v1::UploadAssetResponse response;
    const auto stream = stub_->UploadAsset(&context, &response);
    while (!bytes.empty()) {
      const std::size_t length = static_cast<unsigned char>(bytes[0]);
      v1::UploadAssetRequest request;
      if (!request.ParseFromString(std::string(bytes.substr(1, length)))) break;
      if (!stream->Write(request)) break;
      bytes.remove_prefix(std::min(length + 1, bytes.size()));
    }
    stream->WritesDone();
    if (stream->Finish().error_code() == grpc::StatusCode::INTERNAL) std::abort();
  }

  tbb::task_arena arena_{1};
  Lanes lanes_;
  rpc::Runtime runtime_;
  std::string scene_, lease_;
  std::unique_ptr<grpc::CallbackGenericService> service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<v1::SceneService::Stub> stub_;
};

}  // namespace
}  // namespace lucerna::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lucerna;
  if (size == 0) return 0;
  static fuzz::World world;
  world.answer(static_cast<monitor::Call>(data[0] % monitor::kCalls),
               fuzz::text_of(data + 1, size - 1));
  return 0;
}

#include "server/rpc/server.h"

#include <fmt/core.h>
#include <grpc/health/v1/health.pb.h>
#include <grpc/support/log.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <future>
#include <limits>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/rays/accelerator.h"
#include "server/rpc/address.h"
#include "server/rpc/services.h"
#include "server/runtime/fingerprint.h"

namespace lucerna::rpc {

struct Server::State {
  explicit State(const LaneOptions& options) : lanes(options), runtime(lanes) {}

  std::string address;
  // Destroyed from last to first: calls, then services, then scenes, then lanes.
  Lanes lanes;
  Runtime runtime;
  std::vector<std::unique_ptr<grpc::Service>> services;
  std::unique_ptr<grpc::Server> server;
  bool ended = false;

  absl::Status load(const std::string& path, const std::stop_token& stop);
  absl::Status listen(const ServerOptions& options);
  void end(std::chrono::system_clock::time_point deadline);
};

namespace {

void set_info(const ServerOptions& options, const Fingerprint& fingerprint, int threads,
              v1::GetServerInfoResponse& info) {
  info.set_version(options.version);
  info.set_threads(static_cast<std::uint32_t>(threads));
  v1::Limits& limits = *info.mutable_limits();
  limits.set_max_batch_items(options.limits.max_batch_items);
  limits.set_max_tile_pixels(options.limits.max_tile_pixels);
  limits.set_max_samples(options.limits.max_samples);
  limits.set_max_page_size(options.limits.max_page_size);
  limits.set_max_message_bytes(options.limits.max_message_bytes);
  limits.set_interactive_queue(options.lanes.interactive_queue);
  limits.set_bulk_queue(options.lanes.bulk_queue);
  limits.set_max_asset_bytes(options.assets.max_asset_bytes);
  limits.set_asset_budget_bytes(options.assets.budget_bytes);
  limits.set_memory_budget_bytes(options.scenes.memory_budget_bytes);
  limits.set_max_lease_s(options.scenes.max_lease_s);
  limits.set_max_scene_primitives(options.scenes.max_primitives);
  limits.set_max_scene_bytes(options.scenes.max_scene_bytes);
  limits.set_max_picture_texels(options.scenes.max_texels);
  limits.set_max_include_depth(static_cast<std::uint32_t>(options.scenes.max_include_depth));
  limits.set_max_tokens(options.scenes.max_tokens);
  limits.set_max_name_bytes(options.limits.max_name_bytes);
  limits.set_upload_timeout_s(static_cast<double>(options.assets.stall_time.count()));
  v1::NumericFingerprint& f = *info.mutable_fingerprint();
  f.set_digest(fingerprint.digest);
  f.set_build(fingerprint.build);
  f.set_embree(fingerprint.embree);
  f.set_libm(fingerprint.libm);
}

/// Once for the process.
void set_up_grpc() {
  static const bool done = [] {
    // gRPC's messages repeat our errors and report each client that connects or disconnects.
    gpr_set_log_function(
        [](gpr_log_func_args* args) { spdlog::debug(fmt::format("grpc: {}", args->message)); });
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    // Reflection needs the description of this message.  Using it here makes the linker include it.
    (void)grpc::health::v1::HealthCheckRequest::descriptor();
    return true;
  }();
  (void)done;
}

}  // namespace

absl::Status Server::State::load(const std::string& path, const std::stop_token& stop) {
  std::promise<absl::Status> result;
  const absl::Status queued =
      lanes.submit(Lane::kBulk, {.run =
                                     [&](const LaneJobStart& start) {
                                       result.set_value(start.status.ok() ? guarded([&] {
                                         return runtime.scenes->load(path, {.stop = stop}).status();
                                       })
                                                                          : start.status);
                                     },
                                 .stop = stop});
  return queued.ok() ? result.get_future().get() : queued;
}

absl::Status Server::State::listen(const ServerOptions& options) {
  set_up_grpc();
  services = make_services(runtime);
  grpc::ServerBuilder builder;
  // Two servers on one port would answer in turn, each with its own scenes.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  // Clients send keepalive pings while a long call runs.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  const int bytes = static_cast<int>(
      std::min<std::uint64_t>(options.limits.max_message_bytes, std::numeric_limits<int>::max()));
  builder.SetMaxReceiveMessageSize(bytes);
  builder.SetMaxSendMessageSize(bytes);
  int port = 0;
  builder.AddListeningPort(options.listen, grpc::InsecureServerCredentials(), &port);
  for (const auto& service : services) builder.RegisterService(service.get());
  server = builder.BuildAndStart();
  if (server == nullptr || port == 0) {
    return absl::UnavailableError(
        fmt::format("cannot listen on {}: {}", options.listen, why_not_to_listen(options.listen)));
  }
  address = with_port(options.listen, port);
  for (const std::string& name : service_names()) {
    server->GetHealthCheckService()->SetServingStatus(name, true);
  }
  return absl::OkStatus();
}

void Server::State::end(std::chrono::system_clock::time_point deadline) {
  if (std::exchange(ended, true) || server == nullptr) return;
  server->Shutdown(deadline);
  server->Wait();
}

absl::StatusOr<std::unique_ptr<Server>> Server::start(const ServerOptions& options,
                                                      std::stop_token stop) {
  LUCERNA_RETURN_IF_ERROR(check_address(options.listen));
  LUCERNA_ASSIGN_OR_RETURN(auto assets, AssetStore::open(options.assets));
  LUCERNA_ASSIGN_OR_RETURN(auto scenes, SceneStore::open(options.scenes, assets.get()));
  LUCERNA_ASSIGN_OR_RETURN(const std::string embree, embree_kernels(options.scenes.isa));
  auto state = std::make_unique<State>(options.lanes);
  state->runtime.limits = options.limits;
  state->runtime.assets = std::move(assets);
  state->runtime.scenes = std::move(scenes);
  set_info(options, numeric_fingerprint(embree), state->lanes.threads(), state->runtime.info);
  for (const std::string& path : options.load) LUCERNA_RETURN_IF_ERROR(state->load(path, stop));
  if (stop.stop_requested()) return absl::CancelledError("stopped before serving");
  LUCERNA_RETURN_IF_ERROR(state->listen(options));
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}
Server::~Server() {
  state_->runtime.gate.close();
  state_->end(std::chrono::system_clock::now());
}

const std::string& Server::address() const { return state_->address; }

ServerSummary Server::summary() const {
  const SceneStore& scenes = *state_->runtime.scenes;
  const FileListing files = scenes.available();
  return {.root = scenes.root(),
          .available_scenes = files.paths.size(),
          .listing_is_incomplete = files.incomplete,
          .loaded_scenes = scenes.size(),
          .threads = state_->lanes.threads()};
}

void Server::begin_drain() {
  state_->server->GetHealthCheckService()->Shutdown();
  state_->runtime.gate.close();
}

void Server::drain(std::chrono::milliseconds patience) {
  begin_drain();
  // The port stays open meanwhile, so health checks and new calls are answered.
  state_->runtime.gate.wait_until_empty(std::chrono::steady_clock::now() + patience);
  state_->end(std::chrono::system_clock::now());
}

const SceneStore& Server::scenes() const { return *state_->runtime.scenes; }
Lanes& Server::lanes() { return state_->lanes; }

}  // namespace lucerna::rpc

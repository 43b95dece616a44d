#include "server/rpc/server.h"

#include <fmt/format.h>
#include <grpc/support/log.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/resource_quota.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <future>
#include <limits>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/monitor/metric_families.h"
#include "server/monitor/metrics_server.h"
#include "server/rays/accelerator.h"
#include "server/rpc/address.h"
#include "server/rpc/listener.h"
#include "server/rpc/observed_call.h"
#include "server/rpc/services.h"
#include "server/rpc/stats.h"
#include "server/rpc/tls.h"
#include "server/runtime/fingerprint.h"

namespace lucerna::rpc {

struct Server::State {
  explicit State(const LaneOptions& options) : lanes(options), runtime(lanes) {}

  std::string address;
  // Destroyed from last to first: calls, then services, then scenes, then lanes.
  Lanes lanes;
  Runtime runtime;
  std::unique_ptr<grpc::CallbackGenericService> service;
  std::shared_ptr<Tls> tls;                                           // null: none
  std::vector<std::shared_ptr<grpc::ServerCredentials>> credentials;  // gRPC refers to them
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<monitor::MetricsServer> metrics;
  std::string metrics_address;
  // One for each thread of the listener, since an acceptor takes one connection at a time.
  std::vector<std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>> acceptors;
  std::unique_ptr<Listener> listener;
  bool ended = false;

  absl::Status load(const std::string& path, const std::stop_token& stop);
  absl::Status listen(const ServerOptions& options);
  absl::Status serve_metrics(const std::string& address);
  void end(std::chrono::system_clock::time_point deadline);
};

namespace {

// Headers of one call.
constexpr std::uint64_t kMaxHeaderBytes = 16 << 10;
// Smaller messages have room for as many bytes.
constexpr std::uint64_t kLeastMessageBytes = 64 << 20;
// Messages that have not arrived in full, of one connection and of all: so many of the largest.
// Beyond the second gRPC ends calls of any connection.
constexpr std::uint64_t kUnfinishedMessages = 3, kAllUnfinishedMessages = 6;
// What gRPC reads at once.  After more, thousands of calls that were reset would be known too late.
constexpr std::uint64_t kMaxReadBytes = 64 << 10;
// Answers that their clients have not taken, and memory that nothing explains, without a memory
// budget.
constexpr std::uint64_t kMostUnsentBytes = 1ULL << 30, kMostUncountedBytes = 1ULL << 30;
// Memory that nothing explains, and that is always allowed.
constexpr std::uint64_t kUncountedBytes = 48 << 20;
// Calls that have ended for a client, but not yet for gRPC.
constexpr std::uint32_t kSpareCalls = 1000;
// How long a client has to answer a ping.
constexpr std::uint64_t kPingAnswerSeconds = 20;

/// The limits that `Server::reload` may change.
void set_request_limits(const RequestLimits& from, v1::Limits& limits) {
  limits.set_max_batch_items(from.max_batch_items);
  limits.set_max_tile_pixels(from.max_tile_pixels);
  limits.set_max_samples(from.max_samples);
}

void set_info(const ServerOptions& options, const Fingerprint& fingerprint, int threads,
              v1::GetServerInfoResponse& info) {
  info.set_version(options.version);
  info.set_threads(static_cast<std::uint32_t>(threads));
  v1::Limits& limits = *info.mutable_limits();
  set_request_limits(options.limits, limits);
  limits.set_max_page_size(options.limits.max_page_size);
  limits.set_max_message_bytes(options.limits.max_message_bytes);
  limits.set_interactive_queue(options.lanes.interactive_queue);
  limits.set_bulk_queue(options.lanes.bulk_queue);
  limits.set_max_asset_bytes(options.assets.max_asset_bytes);
  limits.set_asset_budget_bytes(options.assets.budget_bytes);
  limits.set_memory_budget_bytes(options.scenes.memory_budget_bytes);
  limits.set_max_lease_s(options.scenes.max_lease_s);
  limits.set_max_scene_primitives(options.scenes.load.max_primitives);
  limits.set_max_scene_bytes(options.scenes.load.max_scene_bytes);
  limits.set_max_picture_texels(options.scenes.load.max_texels);
  limits.set_max_include_depth(static_cast<std::uint32_t>(options.scenes.load.max_include_depth));
  limits.set_max_tokens(options.scenes.load.max_tokens);
  limits.set_max_name_bytes(options.limits.max_name_bytes);
  limits.set_upload_timeout_s(static_cast<double>(options.assets.stall_time.count()));
  v1::NumericFingerprint& f = *info.mutable_fingerprint();
  f.set_digest(fingerprint.digest);
  f.set_build(fingerprint.build);
  f.set_embree(fingerprint.embree);
  f.set_libm(fingerprint.libm);
}

/// Sets what gRPC allows its connections.
void set_arguments(const ServerOptions& options, grpc::ServerBuilder& builder) {
  const ConnectionOptions& connections = options.connections;
  const auto set = [&](const char* argument, std::uint64_t value) {
    builder.AddChannelArgument(argument, static_cast<int>(std::min<std::uint64_t>(
                                             value, std::numeric_limits<int>::max())));
  };
  // Clients send keepalive pings while a long call runs.
  set(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
      1000ULL * connections.least_ping_gap_s);
  set(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // A client that is gone without a word answers no ping, and its connection is closed.
  set(GRPC_ARG_KEEPALIVE_TIME_MS, 1000ULL * connections.ping_s);
  set(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 1000ULL * kPingAnswerSeconds);
  set(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  set(GRPC_ARG_MAX_CONCURRENT_STREAMS, connections.streams);
  set(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 1000ULL * connections.handshake_s);
  if (connections.idle_s > 0) set(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 1000ULL * connections.idle_s);
  const int bytes = static_cast<int>(
      std::min<std::uint64_t>(options.limits.max_message_bytes, std::numeric_limits<int>::max()));
  builder.SetMaxReceiveMessageSize(bytes);
  builder.SetMaxSendMessageSize(bytes);
  // A message of 1 MB may unpack to 1 GB before gRPC looks at its size.
  set(GRPC_COMPRESSION_CHANNEL_ENABLED_ALGORITHMS_BITSET, 1U << GRPC_COMPRESS_NONE);
  set(GRPC_ARG_MAX_METADATA_SIZE, kMaxHeaderBytes);
  set(GRPC_ARG_TCP_READ_CHUNK_SIZE, kMaxReadBytes);
  set(GRPC_ARG_TCP_MAX_READ_CHUNK_SIZE, kMaxReadBytes);
}

/// Once for the process.
void set_up_grpc() {
  static const bool done = [] {
    set_up_protobuf_log();
    // gRPC's messages repeat our errors and report each client that connects or disconnects.
    gpr_set_log_function(
        [](gpr_log_func_args* args) { spdlog::debug(fmt::format("grpc: {}", args->message)); });
    return true;
  }();
  (void)done;
}

}  // namespace

absl::Status check_options(const ServerOptions& options) {
  const ConnectionOptions& connections = options.connections;
  std::vector<std::string> errors;
  const auto add = [&](const absl::Status& status) {
    if (!status.ok()) errors.emplace_back(status.message());
  };
  const auto all = [&] {
    return absl::InvalidArgumentError(fmt::format("{}", fmt::join(errors, "\n")));
  };
  add(check_address("listen", options.listen));
  if (!options.metrics.empty()) add(check_address("metrics", options.metrics));
  if (!errors.empty()) return all();  // their hosts cannot be looked up
  const absl::StatusOr<bool> loopback = is_loopback(options.listen);
  if (!loopback.ok()) return loopback.status();
  if (!*loopback && !connections.tls.given() && !connections.insecure) {
    errors.push_back(
        fmt::format("listen = {}, which other machines can reach; allowed: a loopback address, "
                    "or tls-cert and tls-key, or the option insecure",
                    options.listen));
  }
  if (!options.metrics.empty() && !connections.insecure) {
    const absl::StatusOr<bool> metrics_loopback = is_loopback(options.metrics);
    add(metrics_loopback.status());
    if (metrics_loopback.ok() && !*metrics_loopback) {
      errors.push_back(fmt::format(
          "metrics = {}, which other machines can reach; allowed: a loopback address, or "
          "the option insecure",
          options.metrics));
    }
  }
  if (connections.tls.given()) add(Tls::open(connections.tls).status());
  if (!connections.token_file.empty())
    add(access::read_token_file(connections.token_file).status());
  return errors.empty() ? absl::OkStatus() : all();
}

absl::Status Server::State::load(const std::string& path, const std::stop_token& stop) {
  std::promise<absl::Status> result;
  const auto run = [&](const LaneJobStart& start) {
    const auto load = [&] { return runtime.scenes->load(path, {.stop = stop}).status(); };
    result.set_value(start.status.ok() ? guarded(load) : start.status);
  };
  const absl::Status queued =
      lanes.submit(Lane::kBulk, {.run = run, .stop = stop, .kind = JobKind::kLoad});
  return queued.ok() ? result.get_future().get() : queued;
}

absl::Status Server::State::listen(const ServerOptions& options) {
  set_up_grpc();
  service = make_service(runtime);
  LUCERNA_ASSIGN_OR_RETURN(listener, Listener::open(options.listen, options.connections.limits));
  grpc::ServerBuilder builder;
  set_arguments(options, builder);
  const ConnectionOptions& connections = options.connections;
  const std::uint64_t two_messages = 2ULL * options.limits.max_message_bytes;
  const std::uint64_t budget = options.scenes.memory_budget_bytes;
  const std::uint64_t message = std::max(options.limits.max_message_bytes, kLeastMessageBytes);
  grpc::ResourceQuota quota("lucernad");
  quota.Resize(kAllUnfinishedMessages * message);
  builder.SetResourceQuota(quota);
  for (std::size_t i = 0; i < Listener::kThreads; ++i) {
    credentials.push_back(tls != nullptr ? tls->credentials() : grpc::InsecureServerCredentials());
    acceptors.push_back(builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        credentials.back()));
  }
  builder.RegisterCallbackGenericService(service.get());
  server = builder.BuildAndStart();
  if (server == nullptr) return absl::UnavailableError("gRPC does not start");
  address = with_port(options.listen, listener->port());
  listener->connections().set_patience(
      {.message_bytes = options.limits.max_message_bytes,
       .unfinished_bytes = kUnfinishedMessages * message,
       .calls = 2 * connections.streams + kSpareCalls,
       .unsent_bytes = std::max(two_messages, budget == 0 ? kMostUnsentBytes : budget / 4),
       .idle_s = connections.idle_s,
       .uncounted_bytes = kUncountedBytes + (budget == 0 ? kMostUncountedBytes : budget / 8),
       .counted_bytes = [this] { return runtime.scenes->counted_bytes(); }});
  runtime.connections = &listener->connections();
  runtime.idle_s = connections.idle_s;
  const auto take = [this](std::size_t thread, int from, int connection) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.listener_fd = from;
    parameters.fd = connection;
    acceptors[thread]->HandleNewConnection(&parameters);
  };
  const auto watch = [this] {
    runtime.waits.watch();
    return listener->connections().watch();
  };
  // gRPC has opened its descriptors by now, so they count.
  return listener->start(take, watch);
}

absl::Status Server::State::serve_metrics(const std::string& address) {
  auto started = monitor::MetricsServer::start(
      address, [this] { return monitor::metric_families(stats(runtime), runtime.info); });
  if (!started.ok()) {
    // The library's message does not say why.
    const std::string why(Listener::open(address, {}).status().message());
    return absl::UnavailableError(
        fmt::format("cannot serve metrics on {}: {}", address, why.substr(why.rfind(": ") + 2)));
  }
  metrics = *std::move(started);
  metrics_address = with_port(address, metrics->port());
  return absl::OkStatus();
}

void Server::State::end(std::chrono::system_clock::time_point deadline) {
  if (std::exchange(ended, true) || server == nullptr) return;
  listener->stop();
  // gRPC answers calls that arrive while it shuts down with CANCELLED, which clients do not repeat.
  if (runtime.calls.wait_until_empty(std::chrono::steady_clock::now()))
    listener->connections().close_all();
  server->Shutdown(deadline);
  server->Wait();
  // A lane may still hold a call that gRPC has ended, which counts as in flight.
  runtime.calls.wait_until_empty();
}

absl::StatusOr<std::unique_ptr<Server>> Server::start(const ServerOptions& options,
                                                      std::stop_token stop) {
  LUCERNA_RETURN_IF_ERROR(check_options(options));
  LUCERNA_ASSIGN_OR_RETURN(auto assets, AssetStore::open(options.assets));
  LUCERNA_ASSIGN_OR_RETURN(auto scenes, SceneStore::open(options.scenes, assets.get()));
  LUCERNA_ASSIGN_OR_RETURN(const std::string embree, embree_kernels(options.scenes.isa));
  auto state = std::make_unique<State>(options.lanes);
  state->runtime.limits.set(options.limits);
  if (options.connections.tls.given()) {
    LUCERNA_ASSIGN_OR_RETURN(state->tls, Tls::open(options.connections.tls));
    state->runtime.client_certificates = !options.connections.tls.client_ca.empty();
  }
  if (!options.connections.token_file.empty()) {
    LUCERNA_ASSIGN_OR_RETURN(auto tokens, access::read_token_file(options.connections.token_file));
    state->runtime.access.set_tokens(std::move(tokens));
  }
  state->runtime.assets = std::move(assets);
  state->runtime.scenes = std::move(scenes);
  state->runtime.on_call = options.on_call;
  state->runtime.log_lines_left_out = options.log_lines_left_out;
  state->runtime.max_call_s = options.max_call_s;
  set_info(options, numeric_fingerprint(embree), state->lanes.threads(), state->runtime.info);
  for (const std::string& path : options.load) LUCERNA_RETURN_IF_ERROR(state->load(path, stop));
  if (stop.stop_requested()) return absl::CancelledError("stopped before serving");
  // Metrics must be ready when the server is.
  if (!options.metrics.empty()) LUCERNA_RETURN_IF_ERROR(state->serve_metrics(options.metrics));
  LUCERNA_RETURN_IF_ERROR(state->listen(options));
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}
Server::~Server() {
  state_->runtime.calls.close();
  state_->end(std::chrono::system_clock::now());
}

const std::string& Server::address() const { return state_->address; }
const std::string& Server::metrics_address() const { return state_->metrics_address; }

bool Server::accepts_connections() const { return state_->listener->accepts(); }

ServerSummary Server::summary() const {
  const SceneStore& scenes = *state_->runtime.scenes;
  const FileListing files = scenes.available();
  return {.root = scenes.root(),
          .available_scenes = files.paths.size(),
          .listing_is_incomplete = files.incomplete,
          .loaded_scenes = scenes.size(),
          .threads = state_->lanes.threads()};
}

absl::Status Server::reload(const ServerOptions& options) {
  if (options.connections.token_file.empty() != state_->runtime.access.open()) {
    return absl::InvalidArgumentError(
        "token-file: whether callers need a token changes only at a restart");
  }
  if (options.connections.tls.given() != (state_->tls != nullptr)) {
    return absl::InvalidArgumentError("tls-cert: TLS is switched on and off only at a restart");
  }
  std::vector<access::Token> tokens;
  if (!options.connections.token_file.empty()) {
    LUCERNA_ASSIGN_OR_RETURN(tokens, access::read_token_file(options.connections.token_file));
  }
  if (state_->tls != nullptr) LUCERNA_RETURN_IF_ERROR(state_->tls->reload(options.connections.tls));
  // No step below fails.
  if (!tokens.empty()) state_->runtime.access.set_tokens(std::move(tokens));
  state_->listener->connections().set_limits(options.connections.limits);
  RequestLimits limits = state_->runtime.limits.get();
  limits.max_batch_items = options.limits.max_batch_items;
  limits.max_tile_pixels = options.limits.max_tile_pixels;
  limits.max_samples = options.limits.max_samples;
  state_->runtime.limits.set(limits);
  const std::lock_guard lock(state_->runtime.info_mutex);
  set_request_limits(limits, *state_->runtime.info.mutable_limits());
  return absl::OkStatus();
}

void Server::begin_drain() {
  state_->runtime.serving.stop();
  state_->runtime.calls.close();
}

void Server::drain(std::chrono::milliseconds patience, std::stop_token hurry) {
  begin_drain();
  // The port stays open meanwhile, so health checks and new calls are answered.
  state_->runtime.calls.wait_until_empty(std::chrono::steady_clock::now() + patience,
                                         std::move(hurry));
  state_->end(std::chrono::system_clock::now());
}

const SceneStore& Server::scenes() const { return *state_->runtime.scenes; }
Lanes& Server::lanes() { return state_->lanes; }

}  // namespace lucerna::rpc

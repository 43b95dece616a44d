// A whole lucernad within a process: scenes, lanes, services, health and reflection.
#pragma once

#include <absl/status/statusor.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "server/files/asset_store_options.h"
#include "server/monitor/call_record.h"
#include "server/rpc/connection_options.h"
#include "server/rpc/messages/request_limits.h"
#include "server/runtime/lanes.h"
#include "server/store/scene_store_options.h"

namespace lucerna {
class SceneStore;
}

namespace lucerna::rpc {

struct ServerOptions {
  std::string listen = "127.0.0.1:50051";  ///< HOST:PORT; port 0: a free port
  SceneStoreOptions scenes;
  AssetStoreOptions assets;
  std::string version = "0.0.0";  ///< GetServerInfo reports it
  LaneOptions lanes;
  RequestLimits limits;
  std::vector<std::string> load;  ///< scenes to load before serving

  /// HOST:PORT of the metrics over HTTP; port 0: a free port.  Empty: no metrics.
  std::string metrics;
  /// Gets the record of each call that has ended, on the thread of the call.  May be empty.
  std::function<void(const monitor::CallRecord&)> on_call;
  /// The lines that the log left out, for the statistics.  May be empty.
  std::function<std::uint64_t()> log_lines_left_out;
  /// The longest that a call without a deadline may compute [s]; 0: no limit.
  double max_call_s = 0;
  ConnectionOptions connections;
};

/// Checks what `Server::start` and `Server::reload` check before they change anything: the
/// addresses with their TLS, the certificates and the token file.  INVALID_ARGUMENT with all
/// errors, one a line.
absl::Status check_options(const ServerOptions& options);

/// What a server serves, for its log.
struct ServerSummary {
  std::string root;                    ///< the scene root, absolute
  std::size_t available_scenes = 0;    ///< scene files under it
  bool listing_is_incomplete = false;  ///< there may be more
  std::size_t loaded_scenes = 0;
  int threads = 0;  ///< of computation
};

class Server {
 public:
  /// The server is ready when this returns.  Errors: those of check_options; an address that cannot
  /// be used (UNAVAILABLE), too few file descriptors (RESOURCE_EXHAUSTED),
  /// no such scene root, an unknown isa, a scene that cannot be loaded; CANCELLED by `stop`.
  static absl::StatusOr<std::unique_ptr<Server>> start(const ServerOptions& options,
                                                       std::stop_token stop = {});
  /// Cancels running calls, unless `drain` was called before.
  ~Server();

  /// HOST:PORT with the port in use.
  const std::string& address() const;
  /// HOST:PORT of the metrics; empty: there are none.
  const std::string& metrics_address() const;
  /// Connects to the server's own port, and returns whether it accepts that within some seconds.
  bool accepts_connections() const;
  /// Reads the directories of the scene root.
  ServerSummary summary() const;

  /// Takes over certificates, tokens, and the limits of requests and connections.  Running calls
  /// continue.  All other options stay.  After an error nothing has changed.
  absl::Status reload(const ServerOptions& options);

  /// From now on, health is NOT_SERVING and new calls are UNAVAILABLE.  Running calls are cancelled
  /// after `patience`, or when `hurry` is requested.  Returns when all calls have ended.
  void drain(std::chrono::milliseconds patience, std::stop_token hurry = {});
  /// Only the first part of `drain`, for tests.
  void begin_drain();

  /// The loaded scenes and the waiting requests, for tests.
  const SceneStore& scenes() const;
  Lanes& lanes();

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace lucerna::rpc

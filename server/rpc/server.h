// A whole lucernad within a process: scenes, lanes, services, health and reflection.
#pragma once

#include <absl/status/statusor.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "server/rpc/messages/task.h"
#include "server/runtime/lanes.h"

namespace lucerna::rpc {

struct ServerOptions {
  std::string listen = "127.0.0.1:50051";  ///< HOST:PORT; port 0: a free one
  SceneStoreOptions scenes;
  AssetStoreOptions assets;
  std::string version = "0.0.0";  ///< what GetServerInfo tells
  LaneOptions lanes;
  RequestLimits limits;
  std::vector<std::string> load;  ///< scenes that are loaded before it serves
};

class Server {
 public:
  /// Serves when it returns.  Errors: an address that cannot be listened at (UNAVAILABLE), no such
  /// scene root, an unknown isa, a scene that cannot be loaded; CANCELLED by `stop`.
  static absl::StatusOr<std::unique_ptr<Server>> start(const ServerOptions& options,
                                                       std::stop_token stop = {});
  /// Ends without patience where it was not drained.
  ~Server();

  /// HOST:PORT with the port that was found.
  const std::string& address() const;

  /// Health says NOT_SERVING and new calls are UNAVAILABLE from now on; running calls may take
  /// `patience` to end and are cancelled then.  Returns when all have ended.
  void drain(std::chrono::milliseconds patience);
  /// The first part of `drain` alone: for tests.
  void begin_drain();

  /// For tests: what is loaded, and what is waiting.
  const SceneStore& scenes() const;
  Lanes& lanes();

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace lucerna::rpc

// Accepts connections and passes them to gRPC.
//
// gRPC 1.51 accepts connections itself, but stops for ever once no file descriptor is left
// (https://github.com/grpc/grpc/issues/20418).  It has no limit on connections either.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/rpc/connection_options.h"
#include "server/rpc/connections.h"

namespace lucerna::rpc {

/// Thread-safe.
class Listener {
 public:
  /// Binds and listens on all addresses of HOST:PORT; port 0 chooses a free one.  UNAVAILABLE with
  /// the reason of the operating system.
  static absl::StatusOr<std::unique_ptr<Listener>> open(const std::string& address,
                                                        const ConnectionLimits& limits);
  /// Stops accepting.
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// The threads that accept.  gRPC reads what has arrived while it takes a connection over, and a
  /// client that sends without pause keeps the thread.
  static constexpr std::size_t kThreads = 8;

  int port() const { return port_; }
  /// Calls `take` with each new connection on one of kThreads threads, and `watch` on another
  /// whenever the time that it returned has passed.  `take` owns the descriptor.  Call this when
  /// the process has opened its other files. RESOURCE_EXHAUSTED if the limit of open files (ulimit
  /// -n) leaves no room for connections.  A smaller room than the limit of connections lowers that
  /// limit.
  absl::Status start(std::function<void(std::size_t thread, int listener, int connection)> take,
                     const std::function<std::chrono::milliseconds()>& watch);
  Connections& connections() { return connections_; }
  /// Connects to its own port, and returns whether it accepts that within some seconds.
  bool accepts() const;
  /// Stops accepting.  Connections stay.
  void stop();

 private:
  explicit Listener(const ConnectionLimits& limits) : limits_(limits), connections_(limits) {}
  void run(std::size_t thread);
  void accept_one(std::size_t thread, int listener);
  /// -1 if there is none.
  int accept_from(int listener);

  int port_ = 0;
  std::vector<int> listeners_;
  int wake_ = -1;   // descriptor that ends the threads
  int spare_ = -1;  // given up to close a connection when no descriptor is left
  const ConnectionLimits limits_;
  Connections connections_;
  std::function<void(std::size_t, int, int)> take_;
  std::vector<std::thread> threads_;
  std::jthread watch_;
  std::atomic<std::uint64_t> accepted_{0};  // connections so far, and refused ones
  std::mutex mutex_;
  // Guarded by mutex_: connections refused since the last line of the log, and when the next may
  // come.
  std::uint64_t refused_ = 0;
  std::chrono::steady_clock::time_point next_line_;
};

}  // namespace lucerna::rpc

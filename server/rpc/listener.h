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
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/rpc/doors.h"

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

  int port() const { return port_; }
  /// Calls `take` with each new connection.  `take` owns the descriptor.  Call this when the
  /// process has opened its other files.  RESOURCE_EXHAUSTED if the limit of open files (ulimit -n)
  /// leaves no room for connections.  A smaller room than the limit of connections lowers that
  /// limit.
  absl::Status start(std::function<void(int listener, int connection)> take);
  /// Existing connections stay, even if there are more than the new limits allow.
  void set_limits(const ConnectionLimits& limits);
  ConnectionLimits limits() const;
  /// Connects to its own port, and returns whether it accepts that within some seconds.
  bool accepts() const;
  /// Stops accepting.  Connections stay.
  void stop();
  /// Counts a call that was cancelled; `peer` as gRPC names it.  Shuts the connection down if these
  /// are too many in a short time: a call that a client resets at once costs the server a hundred
  /// times as much as the client (CVE-2023-44487).
  void count_cancelled(const std::string& peer);
  /// Connections that are open now.
  std::size_t connections() const;

 private:
  struct Connection {
    std::uint64_t inode;
    std::string peer;  ///< the address
    std::string name;  ///< as gRPC names it
    /// Calls that may still be cancelled at `counted`; they become more with time.
    double cancels;
    std::chrono::steady_clock::time_point counted;
  };

  Listener() = default;
  void run();
  void accept_one(int listener);
  /// Empty if there is room for a connection of the peer, else the reason.
  std::string refusal(const std::string& peer) const;
  /// Forgets connections that gRPC has closed.
  void sweep() const;

  int port_ = 0;
  std::vector<int> listeners_;
  int wake_ = -1;           // descriptor that ends the thread
  int spare_ = -1;          // given up to close a connection when no descriptor is left
  std::uint32_t most_ = 0;  // connections that the limit of open files leaves room for
  std::function<void(int, int)> take_;
  std::thread thread_;
  std::atomic<std::uint64_t> accepted_{0};  // connections so far, and refused ones
  // Of the thread: connections refused since the last line of the log, and when the next may come.
  std::uint64_t refused_ = 0;
  std::chrono::steady_clock::time_point next_line_;

  mutable std::mutex mutex_;
  ConnectionLimits limits_;                           // guarded by mutex_
  mutable std::map<int, Connection> open_;            // guarded by mutex_; by descriptor
  std::unordered_map<std::string, int> descriptors_;  // guarded by mutex_; by Connection::name
};

}  // namespace lucerna::rpc

// The open connections, and what their clients cost the server.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/rpc/connection_options.h"

namespace lucerna::rpc {

/// The calls of one connection.  Thread-safe.
class Connection {
 public:
  void call_ended() { --calls_; }
  /// A call of the contract has begun, whose client may send messages until it is complete.
  void request_begun() { ++requests_; }
  void request_complete() { --requests_; }
  /// A call ended before its request was complete.  At most `bytes` of it are on their way.
  void request_left(std::size_t bytes) {
    left_ += bytes;  // first, for a look between the two
    --requests_;
  }
  void message_taken(std::size_t bytes) { explained_ += bytes + bytes / 256 + kMessageBytes; }
  /// Bytes that gRPC has got and not sent yet.
  void answer_begun(std::size_t bytes) { unsent_ += bytes; }
  void answer_sent(std::size_t bytes) { unsent_ -= bytes; }
  std::uint64_t unsent_bytes() const { return unsent_; }

 private:
  friend class Connections;
  /// Bytes that gRPC may still keep.
  double on_their_way() const { return unexplained_ + excused_; }
  using Clock = std::chrono::steady_clock;
  // The headers of a call, and the frames around a message; TLS adds a 256th.
  static constexpr std::uint64_t kHeaderBytes = 16 << 10, kMessageBytes = 1 << 10;

  std::atomic<std::uint64_t> explained_ = 0;  // bytes that belong to calls
  std::atomic<std::uint32_t> calls_ = 0, requests_ = 0;
  std::atomic<std::uint64_t> unsent_ = 0;
  std::atomic<std::uint64_t> left_ = 0;  // since the last look

  // Guarded by Connections::mutex_.
  int descriptor_ = -1;
  std::uint64_t inode_ = 0;
  std::string peer_;    // the address
  std::string name_;    // as gRPC names it
  double cancels_ = 0;  // calls that may still be cancelled at counted_
  Clock::time_point counted_;
  // When the connection was last looked at.
  Clock::time_point seen_;
  std::uint64_t received_ = 0, acknowledged_ = 0, explained_before_ = 0;
  double unexplained_ = 0;  // bytes that belong to no call
  bool grows_ = false;      // whether unexplained_ grew at the last look
  // Bytes of requests that were left, which may still arrive, and how many more may be left.
  double late_ = 0, may_leave_ = 0;
  double excused_ = 0;  // bytes of requests that were left a short time ago
  Clock::time_point left_at_;
  bool closed_ = false;
  int looks_ = 0;  // in a row, at which bytes waited to be read
  Clock::time_point looks_since_;
  std::uint64_t looks_bytes_ = 0;  // that arrived meanwhile
  Clock::time_point read_;         // when the client last took some of its answers
  std::uint64_t read_bytes_ = 0;
};

/// What a client may do before its connection is closed.
struct ConnectionPatience {
  std::uint64_t message_bytes = 0;             ///< of one message
  std::uint64_t unfinished_bytes = 0;          ///< of all messages that have not arrived in full
  std::uint32_t calls = 0;                     ///< of one connection, until gRPC has released them
  std::uint64_t unsent_bytes = 0;              ///< of all answers that their clients have not taken
  std::uint32_t idle_s = 0;                    ///< without taking any of its answers; 0: for ever
  std::uint64_t uncounted_bytes = UINT64_MAX;  ///< of memory that nothing explains
  /// Memory of scenes, loads and renders [bytes].
  std::function<std::uint64_t()> counted_bytes = [] { return 0; };
};

/// Thread-safe.
class Connections {
 public:
  explicit Connections(const ConnectionLimits& limits) : limits_(limits) {}

  /// Existing connections stay, even if there are more than the new limits allow.
  void set_limits(const ConnectionLimits& limits);
  /// The room that the limit of open files leaves.
  void set_most(std::uint32_t connections);
  void set_patience(const ConnectionPatience& patience);

  /// Keeps a new connection of `peer`, an address, which gRPC will call `name`.  Returns an empty
  /// text, or why there is no room for it.
  std::string add(int descriptor, const std::string& peer, const std::string& name);
  /// The connection that gRPC calls `name`; null if there is none.
  std::shared_ptr<Connection> find(std::string_view name) const;
  /// Connections that are open now.
  std::size_t size() const;

  /// Counts a call until it ends.  Closes the connection if it has more calls than streams may be
  /// open: then calls are reset faster than gRPC can say so.
  void call_begun(Connection& connection);
  /// Counts a call that was cancelled.  Closes the connection if these are too many in a short
  /// time: a call that a client resets at once costs the server a hundred times as much as the
  /// client (CVE-2023-44487).
  void count_cancelled(Connection& connection);
  /// Whether an answer leaves those that wait within their limit.
  bool has_room(std::uint64_t bytes) const;
  void answer_begun(std::uint64_t bytes) { unsent_ += bytes; }
  void answer_sent(std::uint64_t bytes) { unsent_ -= bytes; }
  /// Counts the message that a call has taken last, instead of `before` bytes, which this call
  /// counted until now.
  void message_held(std::uint64_t bytes, std::uint64_t before) { held_ += bytes - before; }
  /// Closes connections that send much that belongs to no call, such as headers without end, that
  /// take much time to be read, or that take none of their answers for a long time.  If
  /// headers seem to fill the memory, closes the connection with the most bytes that belong to no
  /// call.  Returns the time until the next call.
  std::chrono::milliseconds watch();
  /// Ends all connections.  Clients usually still get what gRPC has written.
  void close_all() const;

 private:
  using Map = std::map<int, std::shared_ptr<Connection>>;

  /// Empty if there is room for a connection of the peer, else the reason.
  std::string refusal(const std::string& peer) const;
  /// Forgets connections that gRPC has closed.
  void sweep() const;
  void forget(const Connection& connection) const;
  /// Why the connection must be closed; empty: it may stay.
  std::string complaint(Connection& connection, Connection::Clock::time_point now) const;
  void close(Connection& connection, const std::string& why) const;
  /// The connection that probably fills the memory with headers; null: nobody does.
  std::shared_ptr<Connection> filler() const;
  /// Counts what has arrived since the last look.
  void count_bytes(Connection& connection, std::uint64_t received, std::uint64_t acknowledged,
                   Connection::Clock::time_point now) const;

  std::atomic<std::uint64_t> unsent_ = 0, most_unsent_ = UINT64_MAX;
  std::atomic<std::uint64_t> held_ = 0;  // by messages of calls that have not ended
  std::atomic<std::uint32_t> most_calls_ = UINT32_MAX;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  ConnectionLimits limits_;
  std::uint32_t most_ = UINT32_MAX;
  ConnectionPatience patience_;
  Connection::Clock::time_point next_look_;  // at all connections
  mutable Map open_;                         // by descriptor
  mutable std::unordered_map<std::string_view, std::shared_ptr<Connection>> names_;
};

}  // namespace lucerna::rpc

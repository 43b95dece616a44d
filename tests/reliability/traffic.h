// Sends many calls from one thread, and measures them.  Requests are encoded once and answers are
// not decoded, so that the sender takes little of the processors that it shares with the server.
#pragma once

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

namespace lucerna::reliability {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// `time` after `from`.
Clock::time_point after(Clock::time_point from, Seconds time);
/// The same moment in gRPC's deadlines, which are times of the system's clock.
std::chrono::system_clock::time_point on_system_clock(Clock::time_point at);

/// A call with its encoded request.
struct Message {
  std::string method;  ///< such as "/lucerna.v1.LightingService/SampleLi"
  grpc::ByteBuffer bytes;
};

/// `method` such as "LightingService/SampleLi".
template <typename Request>
Message make_message(const std::string& method, const Request& request) {
  const grpc::Slice slice(request.SerializeAsString());
  return {"/lucerna.v1." + method, grpc::ByteBuffer(&slice, 1)};
}

std::shared_ptr<grpc::Channel> make_channel(const std::string& target);

/// How a call ended.
struct Ended {
  double latency_s;  ///< from the moment that the call was due
  Clock::time_point at;
  grpc::Status status;
};

/// Unary calls to one server over one connection.  Not thread-safe.
class Traffic {
 public:
  explicit Traffic(const std::string& target);
  /// Cancels the calls that run.
  ~Traffic();
  Traffic(const Traffic&) = delete;
  Traffic& operator=(const Traffic&) = delete;

  /// Begins a call that was due at `due`, with a deadline `patience` later.
  void begin(const Message& message, Clock::time_point due, Seconds patience);
  /// Calls `on_end` for each call that ends before `until`.
  void poll(Clock::time_point until, const std::function<void(const Ended&)>& on_end);
  std::size_t running() const { return calls_.size(); }

 private:
  struct Call;
  grpc::CompletionQueue queue_;
  grpc::GenericStub stub_;
  std::unordered_set<Call*> calls_;
};

/// Sends `rate` calls a second for `duration`, however many still run, and waits for all.
std::vector<Ended> open_loop(Traffic& traffic, const std::vector<Message>& messages, double rate,
                             Seconds duration, Seconds patience);
/// Keeps `at_once` calls running for `duration`, and waits for the last.
std::vector<Ended> closed_loop(Traffic& traffic, const std::vector<Message>& messages,
                               std::size_t at_once, Seconds duration, Seconds patience);

std::vector<double> latencies(const std::vector<Ended>& calls, grpc::StatusCode code);

}  // namespace lucerna::reliability

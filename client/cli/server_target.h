// A server as the target of a load.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <stop_token>

#include "client/cli/bench_load.h"
#include "client/cli/bench_questions.h"
#include "client/library/byte_calls.h"

namespace lucerna::bench {

/// Sends the requests in turn.
class ServerTarget final : public Target {
 public:
  /// `client` answers questions about the server; `calls` carries the load.  Both must outlive the
  /// target.  A stop or the deadline of `options` ends the load.
  ServerTarget(const client::Client& client, const client::ByteCalls& calls, Question question,
               const Requests& requests, client::CallOptions options);
  ServerTarget(const ServerTarget&) = delete;
  ServerTarget& operator=(const ServerTarget&) = delete;
  /// Waits for the calls in flight.
  ~ServerTarget() override;

  double now_s() override;
  void send(double due_s) override;
  std::optional<CallEnd> wait(double until_s) override;
  std::optional<double> server_cpu_s() override;
  void cancel() override;
  bool stopped() override;

 private:
  void take(CallEnd end, const absl::StatusOr<std::string>& response);

  const client::Client& client_;
  const client::ByteCalls& calls_;
  const Question question_;
  const Requests& requests_;
  const client::CallOptions options_;
  std::size_t next_ = 0;
  std::stop_source cancel_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<CallEnd> ends_;     // guarded by mutex_
  std::uint64_t in_flight_ = 0;  // guarded by mutex_
};

}  // namespace lucerna::bench

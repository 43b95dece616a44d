// The state that all services of one server share.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <utility>

#include "lucerna/v1/admin.pb.h"
#include "server/monitor/call_statistics.h"
#include "server/rpc/access.h"
#include "server/rpc/connections.h"
#include "server/rpc/messages/task.h"
#include "server/rpc/serving_state.h"
#include "server/rpc/time_model.h"
#include "server/rpc/waits.h"
#include "server/runtime/lanes.h"
#include "server/store/scene_store.h"

namespace lucerna::rpc {

/// Counts the calls in flight, and refuses new ones once it is closed.  Thread-safe.
class CallsInFlight {
 public:
  struct End {
    void operator()(CallsInFlight* calls) const { calls->end(); }
  };
  /// Counts one call until it is destroyed.
  using Counted = std::unique_ptr<CallsInFlight, End>;

  /// Null once it is closed.
  Counted begin();
  void close();
  /// False if calls still ran at `deadline`, or when `hurry` was requested.
  bool wait_until_empty(std::chrono::steady_clock::time_point deadline, std::stop_token hurry = {});
  /// Returns when no call is left.
  void wait_until_empty();

 private:
  void end();
  std::mutex mutex_;
  std::condition_variable_any ended_;
  bool closed_ = false;
  std::size_t count_ = 0;
};

/// The limits of requests, which may change while calls run.  Thread-safe.
class CurrentLimits {
 public:
  RequestLimits get() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  void set(const RequestLimits& limits) {
    const std::lock_guard lock(mutex_);
    now_ = limits;
  }

 private:
  mutable std::mutex mutex_;
  RequestLimits now_;
};

struct Runtime {
  explicit Runtime(Lanes& l) : lanes(l) {}

  CurrentLimits limits;
  access::Access access;
  std::unique_ptr<AssetStore> assets;
  std::unique_ptr<SceneStore> scenes;
  std::mutex info_mutex;
  v1::GetServerInfoResponse info;  // guarded by info_mutex
  CallsInFlight calls;
  Lanes& lanes;
  monitor::CallStatistics statistics;
  TimeModel times;
  /// Gets the record of each call that has ended; may be empty.
  std::function<void(const monitor::CallRecord&)> on_call;
  /// Null: they are not watched.
  Connections* connections = nullptr;
  Waits waits;
  ServingState serving;
  /// Streams of the health and reflection services that may still begin.
  std::atomic<std::int64_t> stream_slots{4096};
  /// How long a call may wait for its request [s]; 0: for ever.
  std::uint32_t idle_s = 0;
  /// Whether clients have certificates that were checked.
  bool client_certificates = false;
  /// The lines that the log left out; may be empty.
  std::function<std::uint64_t()> log_lines_left_out;
  /// The longest that a call without a deadline may compute [s]; 0: no limit.
  double max_call_s = 0;
  std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();

  CallContext context(const access::Caller& caller) {
    return {*scenes,
            *assets,
            limits.get(),
            {caller.name, caller.admin, caller.quota.leases, caller.quota.scenes}};
  }
};

/// Adds a RetryInfo to the RESOURCE_EXHAUSTED of a full lane.
absl::Status lane_error(absl::Status status, Lane lane);

/// The status of stopped work: DEADLINE_EXCEEDED or CANCELLED.
absl::Status stopped_status(LaneJob::Clock::time_point deadline);

/// The exception that is handled now: RESOURCE_EXHAUSTED if memory ran out, else INTERNAL.
absl::Status status_of_exception();
/// `f()`, with exceptions as errors.
template <typename F>
absl::Status guarded(const F& f) {
  try {
    return f();
  } catch (...) {
    return status_of_exception();
  }
}

}  // namespace lucerna::rpc

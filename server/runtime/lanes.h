// Where requests are computed: two lanes with bounded queues, so that a render of an hour never
// keeps a query of a millisecond waiting.
//
// Each lane has threads of its own that take jobs first come, first served, and an oneTBB arena in
// which those threads' loops are helped by oneTBB's workers.  Workers prefer the interactive arena
// and turn to it between two chunks; the lane's own threads are the operating system's to share,
// and those of the bulk lane are marked as less urgent.  So not even a job that is one long chunk
// holds up the other lane.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>

namespace lucerna {

enum class Lane : std::uint8_t { kInteractive, kBulk };

struct LaneOptions {
  int threads = 0;                         ///< that share a loop; 0: one for each processor
  std::uint32_t interactive_queue = 1024;  ///< jobs that may wait
  std::uint32_t bulk_queue = 64;
};

/// What happened to a job before it ran.
struct LaneJobStart {
  /// OK: run it.  Else it must only be answered: CANCELLED (its stop token), DEADLINE_EXCEEDED, or
  /// UNAVAILABLE (the lanes ended).
  absl::Status status;
  double queue_time_s = 0;
};

struct LaneJob {
  using Clock = std::chrono::system_clock;  // gRPC's deadlines are on it

  /// Called exactly once, on a thread of the lane, within its arena (or on the thread that ends the
  /// lanes, with UNAVAILABLE).  Must not throw.
  std::function<void(const LaneJobStart&)> run{};
  std::stop_token stop{};
  Clock::time_point deadline = Clock::time_point::max();
};

/// Thread-safe.
class Lanes {
 public:
  explicit Lanes(const LaneOptions& options);
  /// Jobs that wait are answered UNAVAILABLE; those that run are waited for.
  ~Lanes();

  /// RESOURCE_EXHAUSTED where the lane's queue is full; the job is then not called.
  absl::Status submit(Lane lane, LaneJob job);
  /// The next part of work that was accepted before: goes to the queue's end, however full it is.
  void resume(Lane lane, LaneJob job);

  int threads() const;
  /// Jobs that wait or run.
  std::size_t pending(Lane lane) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucerna

// Two lanes with bounded queues compute requests.  So a query of a millisecond does not wait for a
// render of an hour.
//
// Each lane has its own threads.  Clients take turns, and so do the connections of a client.  Jobs
// of a connection run first come, first served, except late ones.  Each lane has an oneTBB arena,
// in which oneTBB's workers help with the loops of these threads.  Workers prefer the interactive
// arena and move to it between two chunks.  The operating system schedules the threads in an arena
// by its lane: those of the bulk lane have a lower priority, those of the interactive lane run
// sooner when they wake.  So even a job of one long chunk does not delay the other lane.
//
// The bulk lane runs two jobs of each kind at a time.  Up to two further jobs may run, if their
// clients have no running job of that kind.  So neither two endless loads nor two endless renders
// of one client keep another client waiting.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

namespace lucerna {

enum class Lane : std::uint8_t { kInteractive, kBulk };
/// Loads do not take the places of computations, and the other way round.  A step is a short part
/// of a long computation.  Steps and whole computations of one client take turns, so a client with
/// many streams still gets a small answer soon.
enum class JobKind : std::uint8_t { kLoad, kStep, kComputation };

struct LaneOptions {
  int threads = 0;                         ///< of one loop; 0: one for each processor
  std::uint32_t interactive_queue = 1024;  ///< jobs that may wait
  std::uint32_t bulk_queue = 64;
};

/// How a job starts.
struct LaneJobStart {
  /// OK: do the work.  Else only answer with this error: CANCELLED (its stop token),
  /// DEADLINE_EXCEEDED, or UNAVAILABLE (the lanes ended).
  absl::Status status;
  double queue_time_s = 0;
};

struct LaneJob {
  using Clock = std::chrono::system_clock;  // like gRPC's deadlines

  /// Called exactly once, on a thread of the lane within its arena, or with UNAVAILABLE on the
  /// thread that ends the lanes.  Must not throw.
  std::function<void(const LaneJobStart&)> run{};
  std::stop_token stop{};
  Clock::time_point deadline = Clock::time_point::max();
  /// Who sent the request, for the turns of clients.
  std::string client{};
  /// The connection that sent the request, for the turns within a client.  Only compared.
  const void* connection = nullptr;
  JobKind kind = JobKind::kComputation;
  /// The least time that the job takes [s].  A job that cannot end before its deadline does not
  /// run: DEADLINE_EXCEEDED.
  double least_s = 0;
  /// About how long the job takes [s]; 0: unknown.  See Lanes.
  double expected_s = 0;
};

/// The jobs of a lane now.
struct LaneLoad {
  std::size_t waiting = 0, running = 0;
};

/// Thread-safe.
///
/// The jobs of a connection run first come, first served, except those that will probably miss
/// their deadline: later jobs that can still meet theirs run before them.  Otherwise an overloaded
/// lane would only compute answers that come too late.
class Lanes {
 public:
  explicit Lanes(const LaneOptions& options);
  /// Answers waiting jobs with UNAVAILABLE, and waits for running jobs.
  ~Lanes();

  /// RESOURCE_EXHAUSTED if the lane's queue is full; the job is then never called.
  absl::Status submit(Lane lane, LaneJob job);
  /// Appends the next part of work that was accepted before, even if the queue is full.
  void resume(Lane lane, LaneJob job);

  int threads() const;
  /// Jobs that wait or run.
  std::size_t pending(Lane lane) const;
  LaneLoad load(Lane lane) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucerna

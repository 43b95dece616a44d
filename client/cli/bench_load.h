// Loads a target with calls, as a closed or as an open loop.
//
// A closed loop keeps a number of calls in flight: each answer starts the next call.  An open loop
// sends calls at random times, whether or not earlier calls have ended, as independent users do.
// Its latencies count from the time at which a call was due.  So a target that stalls is charged
// for the calls that it delays.
//
// One thread does everything, and the target has the clock.  Tests replace it by a simulation.
#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "client/cli/bench_figures.h"

namespace lucerna::bench {

/// Where calls go.  For one thread.
class Target {
 public:
  virtual ~Target() = default;
  /// Rises [s].
  virtual double now_s() = 0;
  /// Starts a call that was due at that time.
  virtual void send(double due_s) = 0;
  /// The next call that ended.  Nothing if none has ended by `until_s`, or after a stop.
  virtual std::optional<CallEnd> wait(double until_s) = 0;
  /// Processor time that the server has used so far [s]; nothing if it does not tell.
  virtual std::optional<double> server_cpu_s() = 0;
  /// Ends all calls in flight, and returns when they have ended.  Forgets their ends.
  virtual void cancel() = 0;
  /// Whether the user wants the program to end.
  virtual bool stopped() = 0;
};

/// How long a load runs.
struct Plan {
  /// Calls of this time at the start do not count [s].
  double warm_up_s = 1;
  /// Most time after the warm-up [s].
  double time_s = 10;
  /// Closed loop: ends when the throughput of the last `windows` windows is stable.
  double window_s = 1;
  std::size_t windows = 3;
  double stable_share = 0.05;
};

/// Keeps `in_flight` calls in flight, at least 1.  The figures have all calls that ended after the
/// warm-up.  Calls that are still in flight at the end do not count.  Ends early if all calls of a
/// window failed.
Figures closed_loop(Target& target, std::uint32_t in_flight, const Plan& plan);

/// Times between the arrivals of a Poisson process.
class PoissonArrivals {
 public:
  /// `rate` arrivals in a second, above 0.
  PoissonArrivals(double rate, std::uint64_t seed) : random_(seed), gap_s_(rate) {}
  /// The time to the next arrival [s].
  double next_s() { return gap_s_(random_); }

 private:
  std::mt19937_64 random_;
  std::exponential_distribution<double> gap_s_;
};

/// More calls in flight end an open loop, since its target does not keep up.
inline constexpr std::uint64_t kMostInFlight = 10'000;

/// Sends calls at `rate` [1/s], at random times of a Poisson process.  The figures have all calls
/// that were due in `plan.time_s` after the warm-up.  At the end the load waits for all answers, at
/// most `plan.time_s`.  Calls without an answer then count as DEADLINE_EXCEEDED.
Figures open_loop(Target& target, double rate, std::uint64_t seed, const Plan& plan);

}  // namespace lucerna::bench

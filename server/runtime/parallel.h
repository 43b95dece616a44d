// Loops on the threads of the caller's oneTBB arena, and the processor time of helping threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <stop_token>

#include "lights/maths/stop_poll.h"
#include "server/runtime/denormals.h"
#include "server/runtime/work_counts.h"

namespace lucerna {

/// Processor time of this thread so far [ns].
std::int64_t thread_cpu_ns();

/// Sums the processor time of every thread that works on one task.  The thread that made the meter
/// counts from then on.  Other threads count while they run chunks of its `parallel_chunks`.
class CpuMeter {
 public:
  /// Becomes the current meter of this thread until it is destroyed, on the same thread.
  CpuMeter();
  ~CpuMeter();
  CpuMeter(const CpuMeter&) = delete;
  CpuMeter& operator=(const CpuMeter&) = delete;

  /// All threads together, so far [s].  Call it on the thread that made the meter, outside of
  /// loops.
  double seconds() const;

  /// While it lives, this thread works for `meter` (which may be null).
  class Helping {
   public:
    explicit Helping(CpuMeter* meter);
    ~Helping();
    Helping(const Helping&) = delete;
    Helping& operator=(const Helping&) = delete;

   private:
    CpuMeter* meter_;  // null if this thread's time is counted already
    CpuMeter* previous_;
    std::int64_t start_ns_ = 0;
  };
  static CpuMeter* current();

 private:
  CpuMeter* previous_;
  std::int64_t start_ns_;
  std::atomic<std::int64_t> helpers_ns_{0};
};

/// While it lives, the loops of this thread share processors with the jobs that `running` counts.
class SharedProcessors {
 public:
  SharedProcessors(const std::atomic<int>& running, int processors);
  ~SharedProcessors();
  SharedProcessors(const SharedProcessors&) = delete;
  SharedProcessors& operator=(const SharedProcessors&) = delete;

  /// Whether other jobs keep all processors busy.  Help would then only cost switches of threads.
  static bool are_busy();

 private:
  const std::atomic<int>& running_;
  int processors_;
  const SharedProcessors* previous_;
};

/// Calls `f(begin, end)` on chunks of [0, n) with denormals as zeros, in any order and on any
/// thread of the caller's arena. Uses only the caller's thread while SharedProcessors are busy.
/// Chunks are at most `grain` long and start at multiples of `grain`.  Skips chunks that have not
/// started when `stop` is requested, and ends others at their next StopPoll.  A chunk should take
/// 0.1 to 5 ms, so that threads can move to more urgent work between chunks.  Waiting threads do
/// not run other tasks.
template <typename F>
void parallel_chunks(std::size_t n, std::size_t grain, const std::stop_token& stop, F&& f) {
  // A thread may take a chunk of another job while it waits within a scope.
  const auto chunk = [&](std::size_t begin, std::size_t end) {
    const StopScope scope(stop);
    const DenormalsAreZero denormals;
    try {
      f(begin, end);
    } catch (const Stopped&) {
    }
  };
  if (n <= grain) {
    if (n > 0 && !stop.stop_requested()) chunk(0, n);
    return;
  }
  CpuMeter* const meter = CpuMeter::current();
  const std::size_t chunks = (n + grain - 1) / grain;
  const auto run = [&](std::size_t first, std::size_t last) {
    for (std::size_t c = first; c != last && !stop.stop_requested(); ++c)
      chunk(c * grain, c + 1 == chunks ? n : (c + 1) * grain);
  };
  std::size_t done = 0;
  for (; done < chunks && SharedProcessors::are_busy(); ++done) run(done, done + 1);
  if (done == chunks) return;
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(done, chunks, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const CpuMeter::Helping helping(meter);
          run(range.begin(), range.end());
        },
        tbb::simple_partitioner());
  });
}

/// Calls `f(begin, end, work)` in the same way.  Returns the sum of the work that the calls count.
template <typename F>
WorkCounts parallel_work(std::size_t n, std::size_t grain, const std::stop_token& stop, F&& f) {
  std::mutex mutex;
  WorkCounts sum;
  parallel_chunks(n, grain, stop, [&](std::size_t begin, std::size_t end) {
    WorkCounts work;
    f(begin, end, work);
    const std::lock_guard lock(mutex);
    sum += work;
  });
  return sum;
}

}  // namespace lucerna

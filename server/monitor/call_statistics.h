// Counts calls without locks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "server/monitor/call_record.h"
#include "server/monitor/figures.h"

namespace lucerna::monitor {

/// Thread-safe.  Every call adds to a few atomic numbers.  Each kind of call has its own cache
/// lines.
class CallStatistics {
 public:
  void begin(Call call);
  void end(const CallRecord& record);
  /// Sets the fields of `figures` that this object counts.  Numbers that change meanwhile may
  /// belong to different moments.
  void read(Figures& figures) const;

 private:
  using Counter = std::atomic<std::uint64_t>;
  /// Sums in nanoseconds last for 584 years.
  struct Histogram {
    std::array<Counter, kTimeBounds.size() + 1> counts{};
    Counter sum_ns = 0;
    void add(double seconds);
    TimeHistogram read() const;
  };
  struct alignas(64) Counters {
    std::array<Counter, kCodes> ended{};
    Counter begun = 0;
    Histogram compute;
    Counter queue_ns = 0, cpu_ns = 0, total_ns = 0;
    Counter items = 0, samples = 0, rays = 0, request_bytes = 0, response_bytes = 0;
  };

  std::array<Counters, kCalls> calls_;
  std::array<Histogram, 2> waits_;  // by number of Lane
  Counter already_loaded_ = 0;
};

}  // namespace lucerna::monitor

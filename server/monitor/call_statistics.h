// Counts calls without locks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "lucerna/v1/admin.pb.h"
#include "server/monitor/call_record.h"

namespace lucerna::monitor {

/// Upper bounds of the classes of a histogram [s].  A further class has all larger times.
inline constexpr std::array kTimeBounds{1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2,
                                        1e-1, 3e-1, 1.0,  3.0,  10.0, 30.0, 100.0};

/// Thread-safe.  Every call adds to a few atomic numbers.  Each kind of call has its own cache
/// lines.
class CallStatistics {
 public:
  void begin(Call call);
  void end(const CallRecord& record);
  /// Adds every call of kCallTable, and the lanes with their waits.  Numbers that change meanwhile
  /// may belong to different moments.
  void read(v1::GetStatsResponse& stats) const;

 private:
  using Counter = std::atomic<std::uint64_t>;
  /// Sums in nanoseconds last for 584 years.
  struct Histogram {
    std::array<Counter, kTimeBounds.size() + 1> counts{};
    Counter sum_ns = 0;
    void add(double seconds);
    void read(v1::TimeHistogram& out) const;
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

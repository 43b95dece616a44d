// What a load measured: latencies, rates, failures.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace lucerna::bench {

/// The end of one call.
struct CallEnd {
  /// When the call was due, and when its answer was complete, on the clock of the target [s].
  double due_s = 0, end_s = 0;
  absl::Status status;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  /// Segments, receivers, samples, lights or pixels; samples and rays of the answer's Cost.
  std::uint64_t items = 0, samples = 0, rays = 0;
};

/// The quantiles that tables show.
inline constexpr double kQuantiles[] = {0.5, 0.9, 0.99, 0.999};
/// "p50", "p99.9".
std::string quantile_name(double q);

/// Whether rates of equal windows differ by at most `share` of their mean.  False if they are all
/// 0, or if there are fewer than `count`.  Only the last `count` matter.
bool is_stable(const std::vector<double>& rates, std::size_t count, double share);

/// Sums over calls.
class Figures {
 public:
  /// A failed call counts in `failures` and in `bytes_sent` only.
  void add(const CallEnd& end);
  /// Quantile of the latencies of successful calls [s].
  double latency_s(double q) const;
  std::uint64_t calls() const { return latencies_s_.size(); }
  std::uint64_t failed() const;

  std::uint64_t items = 0, bytes_sent = 0, bytes_received = 0, samples = 0, rays = 0;
  /// By gRPC's name of the code.
  std::map<std::string, std::uint64_t> failures;
  /// The last error; OK if there was none.
  absl::Status error;
  /// The time that the rates refer to [s].
  double seconds = 0;
  /// Processor time that the server used meanwhile [s]; nothing if it does not tell.
  std::optional<double> server_cpu_s;
  /// Closed loop: whether the throughput became stable before the time limit.
  bool stable = false;
  /// Open loop: the load ended early, because too many calls waited.
  bool overloaded = false;

 private:
  // Floats: long runs have millions of calls.
  std::vector<float> latencies_s_;
};

}  // namespace lucerna::bench

// Searches for the highest rate that holds a limit.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace lucerna::bench {

/// A limit of a quantile of the latency.
struct LatencyLimit {
  double quantile = 0.99;
  double latency_s = 0;
};

/// Reads "p99=5ms" or "p99.9=0.5s".  Nothing for any other text, for a quantile outside of (0,
/// 100), and for a time that is not above 0.
std::optional<LatencyLimit> read_latency_limit(const std::string& text);

/// The highest rate for which `holds` is true, if it is true for all lower rates.  Doubles or
/// halves `first` (above 0) until the answer changes, then bisects until both ends differ by at
/// most `precision` of the lower one.  Returns a rate that was tried.  Nothing if no rate from
/// `first` / 2^20 holds.  After 20 doublings, returns the last rate.
std::optional<double> highest_rate(const std::function<bool(double)>& holds, double first,
                                   double precision);

}  // namespace lucerna::bench

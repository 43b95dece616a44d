#include "client/cli/rate_search.h"

#include <cmath>

#include "client/terminal/validators.h"

namespace lucerna::bench {
namespace {

constexpr int kMostSteps = 20;

}  // namespace

std::optional<LatencyLimit> read_latency_limit(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (!text.starts_with('p') || equals == std::string::npos) return std::nullopt;
  const auto percent = cli::read_number(text.substr(1, equals - 1));
  const auto latency_s = cli::read_duration(text.substr(equals + 1));
  if (!percent || !(*percent > 0 && *percent < 100)) return std::nullopt;
  if (!latency_s || !(*latency_s > 0) || !std::isfinite(*latency_s)) return std::nullopt;
  return LatencyLimit{.quantile = *percent / 100, .latency_s = *latency_s};
}

std::optional<double> highest_rate(const std::function<bool(double)>& holds, double first,
                                   double precision) {
  double low = first, high = first;
  if (holds(first)) {
    for (int step = 0;; ++step) {
      if (step == kMostSteps) return low;
      high = 2 * low;
      if (!holds(high)) break;
      low = high;
    }
  } else {
    for (int step = 0;; ++step) {
      if (step == kMostSteps) return std::nullopt;
      low = high / 2;
      if (holds(low)) break;
      high = low;
    }
  }
  while (high > (1 + precision) * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace lucerna::bench

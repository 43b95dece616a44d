#include "client/cli/bench_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "proto/common/quantile.h"

namespace lucerna::bench {

std::string quantile_name(double q) { return fmt::format("p{:g}", 100 * q); }

bool is_stable(const std::vector<double>& rates, std::size_t count, double share) {
  if (rates.size() < count || count == 0) return false;
  const auto first = rates.end() - static_cast<std::ptrdiff_t>(count);
  const auto [least, most] = std::minmax_element(first, rates.end());
  const double mean = std::accumulate(first, rates.end(), 0.0) / static_cast<double>(count);
  return mean > 0 && *most - *least <= share * mean;
}

void Figures::add(const CallEnd& end) {
  bytes_sent += end.bytes_sent;
  if (!end.status.ok()) {
    ++failures[absl::StatusCodeToString(end.status.code())];
    error = end.status;
    return;
  }
  bytes_received += end.bytes_received;
  items += end.items;
  samples += end.samples;
  rays += end.rays;
  latencies_s_.push_back(static_cast<float>(end.end_s - end.due_s));
}

double Figures::latency_s(double q) const { return quantile(latencies_s_, q); }

std::uint64_t Figures::failed() const {
  return std::accumulate(failures.begin(), failures.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& f) { return sum + f.second; });
}

}  // namespace lucerna::bench

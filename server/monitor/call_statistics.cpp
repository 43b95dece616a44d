#include "server/monitor/call_statistics.h"

#include <algorithm>
#include <cstddef>

namespace lucerna::monitor {
namespace {

constexpr std::size_t kOk = 0, kUnknownCode = 2;

std::uint64_t nanoseconds(double seconds) {
  return static_cast<std::uint64_t>(1e9 * std::max(0.0, seconds));
}
double seconds(const std::atomic<std::uint64_t>& ns) {
  return 1e-9 * static_cast<double>(ns.load(std::memory_order_relaxed));
}
void add(std::atomic<std::uint64_t>& counter, std::uint64_t n) {
  // Most of these numbers are 0 in most calls.
  if (n > 0) counter.fetch_add(n, std::memory_order_relaxed);
}
std::uint64_t read(const std::atomic<std::uint64_t>& counter) {
  return counter.load(std::memory_order_relaxed);
}

}  // namespace

void CallStatistics::Histogram::add(double s) {
  // Upper bounds belong to their class.
  const auto bound = std::lower_bound(kTimeBounds.begin(), kTimeBounds.end(), s);
  counts[static_cast<std::size_t>(bound - kTimeBounds.begin())].fetch_add(
      1, std::memory_order_relaxed);
  monitor::add(sum_ns, nanoseconds(s));
}

void CallStatistics::Histogram::read(v1::TimeHistogram& out) const {
  for (const double bound : kTimeBounds) out.add_bounds_s(bound);
  for (const Counter& count : counts) out.add_counts(monitor::read(count));
  out.set_sum_s(seconds(sum_ns));
}

void CallStatistics::begin(Call call) {
  monitor::add(calls_[static_cast<std::size_t>(call)].begun, 1);
}

void CallStatistics::end(const CallRecord& record) {
  Counters& c = calls_[static_cast<std::size_t>(record.call)];
  const bool is_code = record.code >= 0 && static_cast<std::size_t>(record.code) < kCodes;
  if (record.compute_s > 0) c.compute.add(record.compute_s);
  if (record.queued) waits_[static_cast<std::size_t>(record.lane)].add(record.queue_s);
  add(c.queue_ns, nanoseconds(record.queue_s));
  add(c.cpu_ns, nanoseconds(record.cpu_s));
  add(c.total_ns, nanoseconds(record.total_s));
  add(c.items, record.items);
  add(c.samples, record.samples);
  add(c.rays, record.rays);
  add(c.request_bytes, record.request_bytes);
  add(c.response_bytes, record.response_bytes);
  add(already_loaded_, record.already_loaded ? 1 : 0);
  // Last: whoever reads this count also reads the numbers above.
  c.ended[is_code ? static_cast<std::size_t>(record.code) : kUnknownCode].fetch_add(
      1, std::memory_order_release);
}

void CallStatistics::read(v1::GetStatsResponse& stats) const {
  for (std::size_t i = 0; i < kCalls; ++i) {
    const Counters& c = calls_[i];
    v1::CallStats& out = *stats.add_calls();
    out.set_method(kCallTable[i].name);
    std::uint64_t ended = 0;
    for (std::size_t code = 0; code < kCodes; ++code) {
      const std::uint64_t n = c.ended[code].load(std::memory_order_acquire);
      if (n == 0) continue;
      ended += n;
      if (code == kOk) out.set_succeeded(n);
      v1::CodeCount* const count = out.add_codes();
      count->set_code(code_name(static_cast<int>(code)));
      count->set_calls(n);
    }
    out.set_failed(ended - out.succeeded());
    const std::uint64_t begun = monitor::read(c.begun);
    out.set_running(begun - std::min(begun, ended));
    c.compute.read(*out.mutable_compute());
    out.set_queue_s(seconds(c.queue_ns));
    out.set_cpu_s(seconds(c.cpu_ns));
    out.set_seconds(seconds(c.total_ns));
    out.set_items(monitor::read(c.items));
    out.set_samples(monitor::read(c.samples));
    out.set_rays(monitor::read(c.rays));
    out.set_request_bytes(monitor::read(c.request_bytes));
    out.set_response_bytes(monitor::read(c.response_bytes));
  }
  for (const Lane lane : {Lane::kInteractive, Lane::kBulk}) {
    v1::LaneStats& out = *stats.add_lanes();
    out.set_name(name_of(lane));
    waits_[static_cast<std::size_t>(lane)].read(*out.mutable_wait());
  }
  stats.set_already_loaded(monitor::read(already_loaded_));
}

}  // namespace lucerna::monitor

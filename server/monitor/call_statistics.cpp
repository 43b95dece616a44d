#include "server/monitor/call_statistics.h"

#include <algorithm>
#include <cstddef>

namespace lucerna::monitor {
namespace {

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

TimeHistogram CallStatistics::Histogram::read() const {
  TimeHistogram out;
  for (std::size_t i = 0; i < counts.size(); ++i) out.counts[i] = monitor::read(counts[i]);
  out.sum_s = seconds(sum_ns);
  return out;
}

void CallStatistics::begin(Call call) {
  monitor::add(calls_[static_cast<std::size_t>(call)].begun, 1);
}

void CallStatistics::end(const CallRecord& record) {
  Counters& c = calls_[static_cast<std::size_t>(record.call)];
  const bool is_code = record.code >= 0 && static_cast<std::size_t>(record.code) < kCodes;
  constexpr std::size_t kUnknown = 2;
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
  c.ended[is_code ? static_cast<std::size_t>(record.code) : kUnknown].fetch_add(
      1, std::memory_order_release);
}

void CallStatistics::read(Figures& figures) const {
  for (std::size_t i = 0; i < kCalls; ++i) {
    const Counters& c = calls_[i];
    CallFigures& out = figures.calls[i];
    for (std::size_t code = 0; code < kCodes; ++code) {
      out.ended[code] = c.ended[code].load(std::memory_order_acquire);
    }
    const std::uint64_t begun = monitor::read(c.begun), ended = out.calls();
    out.running = begun - std::min(begun, ended);
    out.compute = c.compute.read();
    out.queue_s = seconds(c.queue_ns);
    out.cpu_s = seconds(c.cpu_ns);
    out.total_s = seconds(c.total_ns);
    out.items = monitor::read(c.items);
    out.samples = monitor::read(c.samples);
    out.rays = monitor::read(c.rays);
    out.request_bytes = monitor::read(c.request_bytes);
    out.response_bytes = monitor::read(c.response_bytes);
  }
  for (std::size_t lane = 0; lane < waits_.size(); ++lane) {
    figures.lanes[lane].wait = waits_[lane].read();
  }
  figures.already_loaded = monitor::read(already_loaded_);
}

}  // namespace lucerna::monitor

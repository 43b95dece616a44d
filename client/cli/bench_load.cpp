#include "client/cli/bench_load.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace lucerna::bench {
namespace {

/// The server's processor time between two moments.
class CpuMeter {
 public:
  explicit CpuMeter(Target& target) : target_(target), before_s_(target.server_cpu_s()) {}
  std::optional<double> used_s() {
    const std::optional<double> now_s = target_.server_cpu_s();
    if (!now_s || !before_s_) return std::nullopt;
    return *now_s - *before_s_;
  }

 private:
  Target& target_;
  std::optional<double> before_s_;
};

}  // namespace

Figures closed_loop(Target& target, std::uint32_t in_flight, const Plan& plan) {
  for (std::uint32_t i = 0; i < in_flight; ++i) target.send(target.now_s());
  const double warm_s = target.now_s() + plan.warm_up_s;
  while (!target.stopped() && target.now_s() < warm_s) {
    if (target.wait(warm_s)) target.send(target.now_s());
  }

  Figures figures;
  CpuMeter cpu(target);
  const double start_s = target.now_s();
  const double limit_s = start_s + plan.time_s;
  std::vector<double> rates;
  double window_start_s = start_s;
  std::uint64_t calls_before = 0, failed_before = 0;
  double now_s = start_s;
  while (!target.stopped()) {
    const double window_end_s = std::min(window_start_s + plan.window_s, limit_s);
    if (const std::optional<CallEnd> end = target.wait(window_end_s)) {
      // Calls may have ended while the meter asked the server.
      if (end->end_s >= start_s) figures.add(*end);
      target.send(target.now_s());
    }
    now_s = target.now_s();
    if (now_s < window_end_s) continue;
    const std::uint64_t calls = figures.calls() - calls_before;
    if (calls == 0 && figures.failed() > failed_before) break;
    // A window ends late if the target's thread was busy, so its own length gives the rate.
    rates.push_back(static_cast<double>(calls) / (now_s - window_start_s));
    figures.stable = is_stable(rates, plan.windows, plan.stable_share);
    if (figures.stable || now_s >= limit_s) break;
    window_start_s = now_s;
    calls_before = figures.calls();
    failed_before = figures.failed();
  }
  figures.seconds = now_s - start_s;
  figures.server_cpu_s = cpu.used_s();
  target.cancel();
  return figures;
}

Figures open_loop(Target& target, double rate, std::uint64_t seed, const Plan& plan) {
  PoissonArrivals arrivals(rate, seed);
  Figures figures;
  std::optional<CpuMeter> cpu;
  const double warm_s = target.now_s() + plan.warm_up_s;
  // Set at the end of the warm-up.
  double start_s = std::numeric_limits<double>::infinity(), last_due_s = start_s;
  double due_s = target.now_s() + arrivals.next_s();
  double last_end_s = 0;
  std::uint64_t in_flight = 0, measured_in_flight = 0;

  const auto take = [&](const CallEnd& end) {
    --in_flight;
    // Calls of the warm-up were due at the latest when it ended.
    if (end.due_s <= start_s) return;
    --measured_in_flight;
    figures.add(end);
    last_end_s = std::max(last_end_s, end.end_s);
  };
  while (!target.stopped() && due_s < last_due_s && !figures.overloaded) {
    if (!cpu && due_s >= warm_s) {
      cpu.emplace(target);
      // The meter asked the server, so calls that were due meanwhile would be late.
      start_s = target.now_s();
      last_due_s = start_s + plan.time_s;
      due_s = start_s + arrivals.next_s();
    }
    if (const std::optional<CallEnd> end = target.wait(due_s)) take(*end);
    while (due_s <= target.now_s() && due_s < (cpu ? last_due_s : warm_s)) {
      target.send(due_s);
      ++in_flight;
      if (due_s > start_s) ++measured_in_flight;
      due_s += arrivals.next_s();
      if (in_flight > kMostInFlight) {
        figures.overloaded = true;
        break;
      }
    }
  }
  const double patience_s = target.now_s() + plan.time_s;
  while (!target.stopped() && !figures.overloaded && in_flight > 0 && target.now_s() < patience_s) {
    if (const std::optional<CallEnd> end = target.wait(patience_s)) take(*end);
  }
  const double now_s = target.now_s();
  for (; measured_in_flight > 0; --measured_in_flight) {
    figures.add({.due_s = now_s,
                 .end_s = now_s,
                 .status = absl::DeadlineExceededError("no answer before the end of the load")});
    last_end_s = std::max(last_end_s, now_s);
  }
  figures.seconds =
      std::max(0.0, (figures.overloaded ? now_s : std::max(last_end_s, last_due_s)) - start_s);
  if (cpu) figures.server_cpu_s = cpu->used_s();
  target.cancel();
  return figures;
}

}  // namespace lucerna::bench

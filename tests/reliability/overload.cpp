// Ten times as many calls as the server can answer.
#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "proto/common/quantile.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

constexpr double kOverload = 10;
constexpr Seconds kPatience{1.0};

/// Answers that came in time for each second.
double goodput(const std::vector<Ended>& calls, double seconds) {
  const auto good = std::count_if(calls.begin(), calls.end(), [](const Ended& call) {
    return call.status.ok() && call.latency_s <= kPatience.count();
  });
  return static_cast<double>(good) / seconds;
}

}  // namespace

void overload(const Settings& settings, Report& report) {
  // A scene of edge 400 takes 30 MB, one of edge 700 takes 93 MB.
  const SceneFiles files(settings.brief ? 400 : 700);
  const double budget = (settings.brief ? 256.0 : 2048.0) * (1 << 20);
  Subject subject(files, {"--memory-budget", fmt::format("{:.0f}", budget)});
  // The program itself counts in the long form, where it is small beside the budget.
  double own = 0;
  if (settings.brief) {
    const SceneFiles tiny(10);
    own = Subject(tiny).resident_bytes();
  }
  // Fills the memory budget.  Scene 0 stays, since it is used after each load.
  for (std::uint64_t number = 1; number < (settings.brief ? 20U : 26U); ++number) {
    subject.load(files.write(number));
    subject.load("scene0.pbrt");
  }
  double most_bytes = 0;
  for (const bool bulk : {false, true}) {
    const std::string name = bulk ? "tiles" : "queries";
    const Message message = bulk ? subject.tile(64, 64) : subject.irradiance(1024, 64);
    Traffic traffic(subject.target());
    const Seconds time(settings.brief ? 1 : 8);
    double peak = 0;
    for (const std::size_t at_once : {3U, 6U}) {
      const auto calls = closed_loop(traffic, {message}, at_once, time / 2, kPatience * 100);
      report.at_least(name + ": calls below capacity that succeed",
                      static_cast<double>(latencies(calls, grpc::StatusCode::OK).size()),
                      static_cast<double>(calls.size()), "calls");
      peak = std::max(peak, static_cast<double>(calls.size()) /
                                Seconds(calls.back().at - calls.front().at).count());
    }
    std::atomic<bool> done{false};
    std::jthread watch([&] {
      while (!done) {
        most_bytes = std::max(most_bytes, subject.resident_bytes());
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    });
    const auto calls = open_loop(traffic, {message}, kOverload * peak, time, kPatience);
    done = true;
    watch.join();
    const auto refused = latencies(calls, grpc::StatusCode::RESOURCE_EXHAUSTED);
    const auto late = latencies(calls, grpc::StatusCode::DEADLINE_EXCEEDED);
    const auto answered = latencies(calls, grpc::StatusCode::OK);
    report.note(name + ": peak", peak, "calls/s");
    report.time(name + ": peak goodput over goodput at ten times the rate",
                peak / goodput(calls, time.count()), 1 / 0.9, "");
    report.time(name + ": refusals, p99", 1e3 * quantile(refused, 0.99), 20, "ms");
    report.note(name + ": refused", static_cast<double>(refused.size()), "calls");
    report.note(name + ": deadline passed", static_cast<double>(late.size()), "calls");
    report.at_most(
        name + ": calls with other errors",
        static_cast<double>(calls.size() - refused.size() - late.size() - answered.size()), 0,
        "calls");
  }
  report.at_most("resident memory over the memory budget", (most_bytes - own) / budget, 1.1, "");
}

}  // namespace lucerna::reliability

// What metrics and the log cost a server that answers queries of one item.
#include <algorithm>
#include <vector>

#include "proto/common/quantile.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

/// Processor time of the server for each call, and calls in a second.
struct Speed {
  double cpu_s = 0, calls_per_s = 0;
};

Speed slice(const Subject& subject, Traffic& traffic, const Message& message, Seconds time) {
  const double cpu_s = subject.cpu_s();
  const auto begin = Clock::now();
  const auto calls =
      static_cast<double>(closed_loop(traffic, {message}, 4, time, Seconds(60)).size());
  return {(subject.cpu_s() - cpu_s) / calls, calls / Seconds(Clock::now() - begin).count()};
}

}  // namespace

void monitoring(const Settings& settings, Report& report) {
  const SceneFiles files;
  Subject off(files, {"--log-level", "off"}), on(files, {"--metrics", "127.0.0.1:0"});
  Traffic to_off(off.target()), to_on(on.target());
  const Message message = off.one_item();
  const Seconds time(settings.brief ? 0.05 : 0.25);
  // Slices alternate, and each pair is a ratio.  So a slow second of the machine counts for both.
  std::vector<double> cpu, throughput;
  for (int pair = 0; pair < (settings.brief ? 4 : 200); ++pair) {
    Speed without, with;
    if (pair % 2 == 0) {
      without = slice(off, to_off, message, time);
      with = slice(on, to_on, message, time);
    } else {
      with = slice(on, to_on, message, time);
      without = slice(off, to_off, message, time);
    }
    if (pair < 2) continue;  // warms up
    cpu.push_back(100 * (with.cpu_s / without.cpu_s - 1));
    throughput.push_back(100 * (1 - with.calls_per_s / without.calls_per_s));
  }
  report.time("metrics and log: lost throughput of one-item queries, median",
              quantile(throughput, 0.5), 2, "%");
  report.note("the same, middle half of the pairs, from", quantile(throughput, 0.25), "%");
  report.note("to", quantile(throughput, 0.75), "%");
  report.note("more processor time of the server for each call, median", quantile(cpu, 0.5), "%");
  const std::string log = on.server().log();
  report.at_least("lines of calls in the log",
                  static_cast<double>(std::count(log.begin(), log.end(), '\n')), 20, "lines");
}

}  // namespace lucerna::reliability

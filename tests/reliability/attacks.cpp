// Hostile clients: the memory that they take, and how long others wait meanwhile.
#include <fmt/core.h>

#include <array>
#include <cstdlib>
#include <future>
#include <stdexcept>
#include <string>

#include "proto/common/host_port.h"
#include "proto/common/quantile.h"
#include "tests/paths.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/subject.h"

namespace lucerna::reliability {
namespace {

// The names of tests/server/http2_attacks.py.  The short form leaves out those that take a
// processor for long.
constexpr std::array kAttacks{"packed_message",
                              "resets",
                              "resets_of_pictures",
                              "resets_of_uploads",
                              "resets_of_checks",
                              "resets_of_watches",
                              "resets_of_reflection",
                              "resets_of_unknown_calls",
                              "reflection",
                              "half_messages",
                              "many_headers",
                              "empty_frames_of_headers",
                              "pings",
                              "unread_samples",
                              "unread_pictures",
                              "referring_headers",
                              "long_header"};
constexpr std::size_t kBrief = 16;
// On a busy machine the server learns of unfinished messages later.  gRPC's own limit is 384 MiB.
constexpr double kMostMegabytes = 400, kMostBusyMegabytes = 600;

}  // namespace

void attacks(const Settings& settings, Report& report) {
  const SceneFiles files;
  for (std::size_t i = 0; i < (settings.brief ? kBrief : kAttacks.size()); ++i) {
    const std::string name = kAttacks[i];
    Subject subject(files, {"--memory-budget", "200MiB"});
    Traffic traffic(subject.target());
    const auto wait_ms = [&] {
      const auto calls = open_loop(traffic, {subject.thousand_samples()}, 50,
                                   Seconds(settings.brief ? 1 : 5), Seconds(60));
      report.at_least(name + ": calls of others that succeed",
                      static_cast<double>(latencies(calls, grpc::StatusCode::OK).size()),
                      static_cast<double>(calls.size()), "calls");
      return 1e3 * quantile(latencies(calls, grpc::StatusCode::OK), 0.99);
    };
    (void)wait_ms();
    const double alone_ms = wait_ms();
    const std::string command =
        fmt::format("exec timeout 120 /usr/bin/python3 {} {} {} {}",
                    source_path("tests/server/http2_attacks.py"), name,
                    split_host_port(subject.target())->port, subject.scene());
    auto attacker = std::async(std::launch::async, [&] { return std::system(command.c_str()); });
    const double attacked_ms = wait_ms();
    if (attacker.get() != 0) throw std::runtime_error(name + ": the attacker failed");
    report.note(name + ": p99 of others alone", alone_ms, "ms");
    report.time(name + ": p99 of others meanwhile, over alone", attacked_ms / alone_ms, 10, "");
    report.at_most(name + ": most resident memory", 1e-6 * subject.most_resident_bytes(),
                   settings.brief ? kMostBusyMegabytes : kMostMegabytes, "MB");
  }
}

}  // namespace lucerna::reliability

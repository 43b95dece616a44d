// The command doctor: whether this machine can use the server, and why not.
#include <fmt/core.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "client/cli/commands.h"
#include "client/terminal/output.h"
#include "client/terminal/session.h"

namespace lucerna::cli {
namespace {

constexpr double kPatienceS = 5;
// Clocks that keep time by NTP differ by less.
constexpr double kMostClockDifferenceS = 1;
// A server that is this close to its limit of descriptors soon refuses connections.
constexpr double kMostDescriptorShare = 0.9;

struct Check {
  std::string name;
  bool ok = true;
  std::string text;
};

class Report {
 public:
  void add(const std::string& name, bool ok, const std::string& text) {
    checks_.push_back({name, ok, text});
  }
  bool well() const {
    return std::all_of(checks_.begin(), checks_.end(), [](const Check& c) { return c.ok; });
  }
  void print(bool json) const {
    if (json) {
      nlohmann::ordered_json out{{"well", well()}, {"checks", nlohmann::ordered_json::array()}};
      for (const Check& c : checks_)
        out["checks"].push_back({{"name", c.name}, {"ok", c.ok}, {"text", c.text}});
      fmt::print("{}\n", out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
      return;
    }
    Table table({{"", true}, {"check", true}, {"result", true}});
    for (const Check& c : checks_) table.add({c.ok ? "ok" : "FAILED", c.name, c.text});
    fmt::print("{}", table.to_string());
  }

 private:
  std::vector<Check> checks_;
};

/// Whether a TCP connection to HOST:PORT succeeds; the reason if not.  Nothing for other forms of
/// addresses.
std::optional<std::string> why_no_connection(const std::string& target) {
  const std::size_t colon = target.rfind(':');
  if (colon == std::string::npos || target.find('/') != std::string::npos) return std::nullopt;
  std::string host = target.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), target.substr(colon + 1).c_str(), &hints, &found);
  if (error != 0) return fmt::format("the name {} has no address: {}", host, gai_strerror(error));
  std::string why;
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    const int fd = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
    const timeval patience{static_cast<time_t>(kPatienceS), 0};
    if (fd >= 0) setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    const bool connected = fd >= 0 && connect(fd, a->ai_addr, a->ai_addrlen) == 0;
    if (!connected) {
      why = errno == EINPROGRESS ? fmt::format("no answer within {:g} s", kPatienceS)
                                 : std::generic_category().message(errno);
    }
    if (fd >= 0) close(fd);
    if (connected) {
      why.clear();
      break;
    }
  }
  freeaddrinfo(found);
  return why;
}

/// Explains why the first call failed.
std::string why_unreachable(const std::string& target, const absl::Status& status) {
  const std::string message(status.message());
  const std::optional<std::string> tcp = why_no_connection(target);
  if (!tcp) return message;
  if (!tcp->empty()) return *tcp;
  return fmt::format(
      "{} accepts connections, but gRPC gets no answer: it may expect TLS, or be another program "
      "({})",
      target, message);
}

void check_clock(double sent_s, double received_s, double server_s, Report& report) {
  const double half_s = 0.5 * (received_s - sent_s);
  const double ahead_s = server_s - (sent_s + half_s);
  report.add("clock", std::abs(ahead_s) <= kMostClockDifferenceS + half_s,
             fmt::format("the server's clock is {:.3f} s {} this machine's, ± {:.3f} s",
                         std::abs(ahead_s), ahead_s < 0 ? "behind" : "ahead of", half_s));
}

void check_stats(const v1::GetStatsResponse& stats, const v1::Limits& limits, Report& report) {
  const v1::ProcessStats& process = stats.process();
  report.add(
      "descriptors",
      static_cast<double>(process.open_descriptors()) <=
          kMostDescriptorShare * static_cast<double>(process.most_descriptors()),
      fmt::format("{} open, at most {}", process.open_descriptors(), process.most_descriptors()));
  for (const v1::LaneStats& lane : stats.lanes()) {
    const std::uint64_t most =
        lane.name() == "bulk" ? limits.bulk_queue() : limits.interactive_queue();
    report.add(lane.name() + " queue", lane.waiting() < most,
               fmt::format("{} wait, at most {}; {} run", lane.waiting(), most, lane.running()));
  }
  report.add(
      "memory",
      limits.memory_budget_bytes() == 0 || stats.scene_bytes() <= limits.memory_budget_bytes(),
      fmt::format("{} bytes of {} scenes, {}; the process uses {}", stats.scene_bytes(),
                  stats.scenes(),
                  limits.memory_budget_bytes() == 0
                      ? std::string("no limit")
                      : fmt::format("at most {}", limits.memory_budget_bytes()),
                  process.resident_bytes()));
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

void examine(Session& session, Report& report) {
  const auto options = [&] {
    return session.call_options().at_most(std::chrono::duration<double>(kPatienceS));
  };
  const auto info = session.client().get_server_info({}, options());
  if (!info.ok()) {
    const bool reached =
        !absl::IsUnavailable(info.status()) && !absl::IsDeadlineExceeded(info.status());
    report.add("connection", false,
               reached ? std::string(info.status().message())
                       : why_unreachable(session.server(), info.status()));
    return;
  }
  report.add("connection", true, session.server());
  const absl::Status health = session.client().check_health(options());
  report.add("health", health.ok(), health.ok() ? "serving" : std::string(health.message()));
  // Other versions work as long as both have the calls that a command needs.
  report.add("version", true,
             fmt::format("lucernad {}, lucerna {}{}", info->version(), LUCERNA_VERSION,
                         info->version() == LUCERNA_VERSION ? "" : "; these differ"));
  report.add("fingerprint", true, info->fingerprint().digest());
  const v1::Limits& limits = info->limits();
  report.add(
      "limits", true,
      fmt::format("{} items, {} pixels, {} samples, {} bytes a message", limits.max_batch_items(),
                  limits.max_tile_pixels(), limits.max_samples(), limits.max_message_bytes()));
  const double sent_s = now_s();
  const auto stats = session.client().get_stats({}, options());
  if (!stats.ok()) {
    report.add("statistics", false, std::string(stats.status().message()));
  } else {
    check_clock(sent_s, now_s(), stats->time_s(), report);
    check_stats(*stats, limits, report);
  }
  const auto scenes = session.client().list_scenes({}, options());
  if (!scenes.ok()) return report.add("scenes", false, std::string(scenes.status().message()));
  std::string names;
  for (const v1::SceneSummary& scene : scenes->scenes())
    names += fmt::format("{}{} {}", names.empty() ? "" : ", ", scene.scene_id().substr(0, 8),
                         scene.path());
  report.add("scenes", true, names.empty() ? "none is loaded" : names);
}

}  // namespace

void add_doctor_command(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("doctor", "Check whether this machine can use the server, and why not");
  command->footer(
      "The exit status is 0 if all is well, else 1.\nExample:\n  lucerna doctor --server "
      "10.0.0.7:50051");
  command->callback([&session] {
    session.need_one_server("it checks one server at a time");
    Report report;
    examine(session, report);
    report.print(session.json());
    if (!report.well()) session.set_exit_status(kServerRefused);
  });
}

}  // namespace lucerna::cli

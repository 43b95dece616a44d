// The command doctor: whether this machine can use the server, and why not.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/cli/admin_commands.h"
#include "client/library/security.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
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
  void print(const Session& session) const {
    if (session.json()) {
      nlohmann::ordered_json out{{"well", well()}, {"checks", nlohmann::ordered_json::array()}};
      for (const Check& c : checks_)
        out["checks"].push_back({{"name", c.name}, {"ok", c.ok}, {"text", c.text}});
      shell::print_text(stdout, "{}\n",
                        out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
      return;
    }
    Table table({{"", true}, {"check", true}, {"result", true}});
    for (const Check& c : checks_)
      table.add({c.ok ? Cell::coloured("ok", shell::Colour::kGood)
                      : Cell::coloured("FAILED", shell::Colour::kBad),
                 c.name, c.text});
    session.show(table);
  }

 private:
  std::vector<Check> checks_;
};

/// Reports the step of the connection that fails, after a first call without an answer.
void explain(const Session& session, const absl::Status& status, Report& report) {
  const client::Security security = session.security();
  const client::Obstacle obstacle = client::find_obstacle(session.server(), security);
  if (obstacle.step == client::ConnectStep::kAddress) {
    return report.add("connection", false, obstacle.why);
  }
  report.add("connection", true, fmt::format("{} accepts connections", session.server()));
  if (obstacle.step == client::ConnectStep::kTls) return report.add("TLS", false, obstacle.why);
  if (security.tls) report.add("TLS", true, "the certificates are good");
  report.add("gRPC", false,
             fmt::format("no answer, so another program may listen there: {}",
                         std::string(status.message())));
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
  if (absl::IsUnavailable(info.status()) || absl::IsDeadlineExceeded(info.status())) {
    return explain(session, info.status(), report);
  }
  const client::Security security = session.security();
  report.add("connection", true, session.server());
  report.add("TLS", true, security.tls ? "the certificates are good" : "not used");
  report.add("token", info.ok(),
             !info.ok()               ? std::string(info.status().message())
             : security.token.empty() ? "none is needed"
                                      : "accepted");
  const absl::Status health = session.client().check_health(options());
  report.add("health", health.ok(), health.ok() ? "serving" : std::string(health.message()));
  if (!info.ok()) return;
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
    // Most callers need no statistics, so a token without that role is no fault.
    report.add("statistics", absl::IsPermissionDenied(stats.status()),
               std::string(stats.status().message()));
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
  CLI::App* command = app.add_subcommand(
      "doctor", "Check whether this machine can use the server, and name what fails");
  command->footer(
      "The exit status is 0 if all is well, else 1.\nExample:\n  lucerna doctor --server "
      "10.0.0.7:50051");
  session.prints_table(*command);
  command->callback([&session] {
    session.need_one_server("it checks one server at a time");
    Report report;
    examine(session, report);
    report.print(session);
    if (!report.well()) session.set_exit_status(kServerRefused);
  });
}

}  // namespace lucerna::cli

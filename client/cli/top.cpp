// The command top: what a server does, live.
#include "client/cli/top.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>

#include "client/cli/admin_commands.h"
#include "client/terminal/output.h"
#include "client/terminal/print.h"
#include "client/terminal/session.h"
#include "client/terminal/validators.h"

namespace lucerna::cli {
namespace {

/// SampleLi of lucerna.v1.LightingService/SampleLi.
std::string short_name(const std::string& method) { return method.substr(method.rfind('/') + 1); }

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(bytes));
}

std::string text_of_time(double seconds) {
  const auto s = static_cast<std::uint64_t>(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
  return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
}

std::uint64_t total(const v1::TimeHistogram& times) {
  return std::accumulate(times.counts().begin(), times.counts().end(), std::uint64_t{0});
}

/// Mean of the times between two moments [ms]; empty if there were none.
std::string mean_ms(const v1::TimeHistogram& before, const v1::TimeHistogram& now) {
  const std::uint64_t n = total(now) - total(before);
  if (n == 0) return {};
  return fmt::format("{:.3g}", 1e3 * (now.sum_s() - before.sum_s()) / static_cast<double>(n));
}

std::string rate(std::uint64_t before, std::uint64_t now, double seconds) {
  if (now == before || seconds <= 0) return {};
  return fmt::format("{:.4g}", static_cast<double>(now - before) / seconds);
}

const v1::CallStats& call_of(const v1::GetStatsResponse& stats, const std::string& method) {
  for (const v1::CallStats& call : stats.calls())
    if (call.method() == method) return call;
  return v1::CallStats::default_instance();
}

Table calls_table(const v1::GetStatsResponse& before, const v1::GetStatsResponse& now,
                  double seconds) {
  Table table({{"call", true},
               {"running"},
               {"calls/s"},
               {"failed/s"},
               {"compute [ms]"},
               {"items/s"},
               {"samples/s"},
               {"rays/s"}});
  for (const v1::CallStats& call : now.calls()) {
    const v1::CallStats& old = call_of(before, call.method());
    table.add({short_name(call.method()), call.running() > 0 ? std::to_string(call.running()) : "",
               rate(old.succeeded() + old.failed(), call.succeeded() + call.failed(), seconds),
               rate(old.failed(), call.failed(), seconds), mean_ms(old.compute(), call.compute()),
               rate(old.items(), call.items(), seconds),
               rate(old.samples(), call.samples(), seconds),
               rate(old.rays(), call.rays(), seconds)});
  }
  return table;
}

Table lanes_table(const v1::GetStatsResponse& before, const v1::GetStatsResponse& now) {
  Table table({{"lane", true}, {"waiting"}, {"running"}, {"wait [ms]"}});
  for (int i = 0; i < now.lanes_size(); ++i) {
    const v1::LaneStats& lane = now.lanes(i);
    const v1::TimeHistogram& old =
        i < before.lanes_size() ? before.lanes(i).wait() : v1::TimeHistogram::default_instance();
    table.add({lane.name(), std::to_string(lane.waiting()), std::to_string(lane.running()),
               mean_ms(old, lane.wait())});
  }
  return table;
}

/// Waits until the time has passed.  False if the program must end.
bool wait(const std::stop_token& stop, double seconds) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, std::chrono::duration<double>(seconds), [] { return false; });
  return !stop.stop_requested();
}

void top(Session& session, double every_s, bool once) {
  session.need_one_server("each server has its own statistics");
  if (session.csv() && !once) wrong_use("--output csv: lucerna top needs --once too");
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  std::optional<v1::GetStatsResponse> before;
  do {
    v1::GetStatsResponse now =
        session.value_or_fail(session.client().get_stats({}, session.call_options()));
    if (session.json()) {
      shell::print_text(stdout, "{}", to_json(now));
    } else if (session.csv()) {
      // Of the calls since the server started.
      session.show(calls_table(v1::GetStatsResponse::default_instance(), now, now.uptime_s()));
    } else {
      // Clears the terminal.
      if (terminal && !once) shell::print_as_is(stdout, "\033[H\033[J");
      shell::print_text(stdout, "lucernad at {}, ", session.server());
      shell::print_as_is(
          stdout, top_text(before ? &*before : nullptr, now, shell::has_colours(STDOUT_FILENO)));
    }
    std::fflush(stdout);
    before = std::move(now);
  } while (!once && wait(session.call_options().stop, every_s));
  // A signal that ends the wait ends the program as it ends a call.
  if (!once) session.fail(absl::CancelledError("interrupted"));
}

}  // namespace

std::string top_text(const v1::GetStatsResponse* before, const v1::GetStatsResponse& now,
                     bool colours) {
  const bool restarted = before != nullptr && before->uptime_s() > now.uptime_s();
  const v1::GetStatsResponse& old =
      before == nullptr || restarted ? v1::GetStatsResponse::default_instance() : *before;
  const double seconds = now.uptime_s() - old.uptime_s();
  const v1::ProcessStats& process = now.process();
  std::string text = fmt::format("up {}; figures of the last {}\n", text_of_time(now.uptime_s()),
                                 text_of_time(seconds));
  text += fmt::format("processors {:.2f}, memory {}, descriptors {} of {}, threads {}\n",
                      seconds > 0 ? (process.cpu_s() - old.process().cpu_s()) / seconds : 0.0,
                      megabytes(process.resident_bytes()), process.open_descriptors(),
                      process.most_descriptors(), process.threads());
  text += fmt::format("scenes {} in {}, leases {}, uploaded files {}\n\n", now.scenes(),
                      megabytes(now.scene_bytes()), now.leases(), megabytes(now.asset_bytes()));
  text += lanes_table(old, now).to_string(colours) + "\n" +
          calls_table(old, now, seconds).to_string(colours);
  return text;
}

void add_top_command(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("top", "Show live what the server does");
  command->footer(
      "The first table shows means since the server started, further tables since the table "
      "before.\nExample:\n  lucerna top\n  lucerna top --once --json");
  const auto every_s = std::make_shared<double>(2);
  const auto once = std::make_shared<bool>(false);
  command->add_option("--every", *every_s, "Time between two tables; default: 2s")
      ->type_name("TIME")
      ->transform(duration());
  command->add_flag("--once", *once, "Print one table and end");
  session.prints_table(*command);
  command->callback([&session, every_s, once] { top(session, *every_s, *once); });
}

}  // namespace lucerna::cli

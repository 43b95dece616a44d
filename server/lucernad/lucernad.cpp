// lucernad: the server program.
#include <absl/strings/str_split.h>
#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "server/lucernad/command_line.h"
#include "server/lucernad/configuration.h"
#include "server/monitor/call_log.h"
#include "server/monitor/log_format.h"
#include "server/monitor/log_limit.h"
#include "server/monitor/unblocking_sink.h"
#include "server/rpc/server.h"
#include "server/rpc/tls.h"
#include "server/runtime/scheduling.h"
#include "server/runtime/service_manager.h"
#include "server/runtime/signals.h"

namespace {

using lucerna::config::Configuration;

/// Bytes for people: "8.0 GiB".
std::string describe_bytes(std::uint64_t bytes) {
  constexpr const char* kUnits[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
  if (bytes < 1024) return fmt::format("{} bytes", bytes);
  auto value = static_cast<double>(bytes);
  int unit = 0;
  for (; value >= 1024 && unit < 4; ++unit) value /= 1024;
  return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

void log_start(const lucerna::rpc::ServerOptions& options, const lucerna::rpc::Server& server) {
  const lucerna::rpc::ServerSummary serves = server.summary();
  const std::uint64_t budget = options.scenes.memory_budget_bytes;
  spdlog::info(fmt::format("lucernad {} listens on {}", options.version, server.address()));
  spdlog::info(fmt::format("scene root {}: {} scene files{}, {} scenes loaded", serves.root,
                           serves.available_scenes, serves.listing_is_incomplete ? " or more" : "",
                           serves.loaded_scenes));
  for (const std::string& warning : lucerna::rpc::certificate_warnings(options.connections.tls))
    spdlog::warn(warning);
  const lucerna::rpc::ConnectionOptions& connections = options.connections;
  spdlog::info(fmt::format("{}, {}", connections.tls.given() ? "TLS" : "no TLS",
                           connections.token_file.empty()
                               ? "no tokens: every caller may do everything"
                               : "callers need a token"));
  spdlog::info(fmt::format("{} threads, memory budget {}", serves.threads,
                           budget > 0 ? describe_bytes(budget) : "unlimited"));
}

struct Log {
  std::shared_ptr<lucerna::monitor::CallLog> calls;
  std::shared_ptr<lucerna::monitor::UnblockingSink> out;
};

/// Directs all lines to stderr in this form.
Log start_log(const lucerna::config::LogOptions& options) {
  using lucerna::monitor::LogFormat;
  const LogFormat format = options.format == "json" ? LogFormat::kJson : LogFormat::kText;
  const spdlog::level::level_enum level = spdlog::level::from_str(options.level);
  // The lines of calls have a limit of their own, so they never displace the server's other lines.
  const auto out = std::make_shared<lucerna::monitor::UnblockingSink>(STDERR_FILENO);
  out->set_formatter(lucerna::monitor::make_formatter(format));
  const auto limit = [&] {
    return std::make_shared<lucerna::monitor::LogLimit>(out, options.lines_per_second);
  };
  const auto logger = std::make_shared<spdlog::logger>("lucernad", limit());
  logger->set_level(level);
  spdlog::set_default_logger(logger);
  return {std::make_shared<lucerna::monitor::CallLog>(format, level, limit()), out};
}

/// One line for each error of the text.
void print_errors(const std::string& text) {
  for (const std::string& line : std::vector<std::string>(absl::StrSplit(text, '\n')))
    fmt::print(stderr, "lucernad: {}\n", line);
}

/// Ends and reloads the server as signals ask for it.
class Control {
 public:
  explicit Control(lucerna::config::Given given) : given_(std::move(given)) {}

  void on_signal(int signal) {
    switch (signal) {
      case SIGTERM:
      case SIGINT:
        spdlog::info(signal == SIGTERM ? "got SIGTERM" : "got SIGINT");
        // The second signal ends the drain.
        (stop_.stop_requested() ? hurry_ : stop_).request_stop();
        break;
      case SIGHUP:
        spdlog::info("got SIGHUP");
        reload();
        break;
      default:
        spdlog::info(
            fmt::format("got {}, which has no effect", signal == SIGUSR1 ? "SIGUSR1" : "SIGUSR2"));
    }
  }

  /// From now on SIGHUP reloads `server`, which started with `configuration`.
  void set_server(lucerna::rpc::Server* server, const Configuration& configuration) {
    const std::lock_guard lock(mutex_);
    server_ = server;
    held_ = configuration.held;
  }

  std::stop_token stop() const { return stop_.get_token(); }
  std::stop_token hurry() const { return hurry_.get_token(); }
  /// Returns after SIGTERM or SIGINT.
  void wait() {
    std::unique_lock lock(mutex_);
    signalled_.wait(lock, stop(), [] { return false; });
  }

 private:
  /// Reads the configuration file again, and everything that the configuration names.
  void reload() {
    const std::lock_guard lock(mutex_);
    if (server_ == nullptr) return;  // it still starts, and has read the files just now
    lucerna::notify_service_manager("RELOADING=1");
    reload_server();
    lucerna::notify_service_manager("READY=1");
  }

  void reload_server() {
    const Configuration now = lucerna::config::configure(given_);
    if (!now.errors.empty()) {
      for (const std::string& error : now.errors) spdlog::error(error);
      spdlog::error("not reloaded: the configuration has errors");
      return;
    }
    if (const absl::Status status = server_->reload(now.options.server); !status.ok()) {
      spdlog::error(fmt::format("not reloaded: {}", std::string(status.message())));
      return;
    }
    for (const std::string& warning :
         lucerna::rpc::certificate_warnings(now.options.server.connections.tls))
      spdlog::warn(warning);
    for (std::size_t i = 0; i < now.held.size(); ++i) {
      if (now.held[i].value == held_[i].value) continue;
      if (now.held[i].reloads) {
        spdlog::info(fmt::format("{} is now {}", now.held[i].name, now.held[i].value));
        held_[i] = now.held[i];
      } else {
        spdlog::warn(fmt::format("{} stays {} until a restart", now.held[i].name, held_[i].value));
      }
    }
    spdlog::info("reloaded certificates, tokens and limits");
  }

  lucerna::config::Given given_;
  std::stop_source stop_, hurry_;
  std::mutex mutex_;
  lucerna::rpc::Server* server_ = nullptr;   // guarded by mutex_
  std::vector<lucerna::config::Held> held_;  // guarded by mutex_
  std::condition_variable_any signalled_;
};

int serve(const Configuration& configuration, const lucerna::config::Given& given) {
  const lucerna::rpc::ServerOptions& options = configuration.options.server;
  Control control(given);
  const lucerna::Signals signals([&](int signal) { control.on_signal(signal); });
  const auto server = lucerna::rpc::Server::start(options, control.stop());
  if (!server.ok()) {
    // A signal before the server is ready is not a failure.
    if (control.stop().stop_requested()) return 0;
    print_errors(std::string(server.status().message()));
    return 1;
  }
  log_start(options, **server);
  if (!(*server)->metrics_address().empty())
    fmt::print("metrics on http://{}/metrics\n", (*server)->metrics_address());
  control.set_server(server->get(), configuration);
  lucerna::notify_service_manager("READY=1");
  std::optional<lucerna::Watchdog> watchdog(std::in_place,
                                            [&] { return (*server)->accepts_connections(); });
  fmt::print("listening on {}\n", (*server)->address());
  std::fflush(stdout);
  control.wait();
  lucerna::notify_service_manager("STOPPING=1");
  const std::chrono::seconds drain_time(configuration.options.drain_seconds);
  spdlog::info(fmt::format("draining for at most {} s", drain_time.count()));
  (*server)->drain(drain_time, control.hurry());
  watchdog.reset();
  control.set_server(nullptr, configuration);
  spdlog::info("ended");
  return 0;
}

int run(int argc, char** argv) {
  const lucerna::config::CommandLine line =
      lucerna::config::parse_command_line(argc, argv, LUCERNA_VERSION);
  if (line.exit_status) return *line.exit_status;
  Configuration configuration = lucerna::config::configure(line.given);
  configuration.options.server.version = LUCERNA_VERSION;
  for (const std::string& error : configuration.errors) {
    fmt::print(stderr, "lucernad: {}\n", error);
  }
  if (!configuration.errors.empty()) return 2;
  for (const std::string& warning : configuration.warnings) {
    fmt::print(stderr, "lucernad: warning: {}\n", warning);
  }
  if (line.check) {
    const absl::Status checked = lucerna::rpc::check_options(configuration.options.server);
    if (!checked.ok()) {
      print_errors(std::string(checked.message()));
      return 2;
    }
    for (const std::string& warning :
         lucerna::rpc::certificate_warnings(configuration.options.server.connections.tls))
      fmt::print(stderr, "lucernad: warning: {}\n", warning);
    fmt::print("{}", lucerna::config::describe(configuration));
    return 0;
  }
  const Log log = start_log(configuration.options.log);
  lucerna::rpc::ServerOptions& options = configuration.options.server;
  // The level decides whether calls are logged; without them the server collects less.
  if (spdlog::should_log(spdlog::level::info)) {
    options.on_call = [log](const auto& record) { log.calls->write(record); };
    options.log_lines_left_out = [log] { return log.calls->left_out() + log.out->left_out(); };
  }
  return serve(configuration, line.given);
}

}  // namespace

// The settings of jemalloc, which reads this name.  Each processor has an arena.  A thread of
// jemalloc returns memory that nobody has used for a second, also while the server is idle.
extern "C" {
const char* malloc_conf = "background_thread:true,percpu_arena:percpu,dirty_decay_ms:1000";
}

int main(int argc, char** argv) {
  // All threads inherit this, those of gRPC too.  The bulk lane's threads return to the default, so
  // that a small query does not wait for them.
  lucerna::set_time_slice(lucerna::TimeSlice::kShort);
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "lucernad: %s\n", error.what());
    return 1;
  }
}

// lucernad: the server program.
#include <fmt/core.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <mutex>
#include <stop_token>
#include <string>

#include "server/config/command_line.h"
#include "server/config/configuration.h"
#include "server/rpc/server.h"
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
  spdlog::info(fmt::format("{} threads, memory budget {}", serves.threads,
                           budget > 0 ? describe_bytes(budget) : "unlimited"));
}

/// Ends and reloads the server as signals ask for it.
class Control {
 public:
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
        break;
      default:
        spdlog::info(
            fmt::format("got {}, which has no effect", signal == SIGUSR1 ? "SIGUSR1" : "SIGUSR2"));
    }
  }

  std::stop_token stop() const { return stop_.get_token(); }
  std::stop_token hurry() const { return hurry_.get_token(); }
  /// Returns after SIGTERM or SIGINT.
  void wait() {
    std::unique_lock lock(mutex_);
    signalled_.wait(lock, stop(), [] { return false; });
  }

 private:
  std::stop_source stop_, hurry_;
  std::mutex mutex_;
  std::condition_variable_any signalled_;
};

int serve(const Configuration& configuration) {
  const lucerna::rpc::ServerOptions& options = configuration.options.server;
  Control control;
  const lucerna::Signals signals([&](int signal) { control.on_signal(signal); });
  const auto server = lucerna::rpc::Server::start(options, control.stop());
  if (!server.ok()) {
    // A signal before the server is ready is not a failure.
    if (control.stop().stop_requested()) return 0;
    fmt::print(stderr, "lucernad: {}\n", std::string(server.status().message()));
    return 1;
  }
  log_start(options, **server);
  fmt::print("listening on {}\n", (*server)->address());
  std::fflush(stdout);
  control.wait();
  const std::chrono::seconds drain_time(configuration.options.drain_seconds);
  spdlog::info(fmt::format("draining for at most {} s", drain_time.count()));
  (*server)->drain(drain_time, control.hurry());
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
    fmt::print("{}", lucerna::config::describe(configuration));
    return 0;
  }
  spdlog::set_default_logger(spdlog::stderr_logger_mt("lucernad"));
  // ISO 8601 with the zone's offset, and the level.
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z [%l] %v");
  return serve(configuration);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    (void)std::fprintf(stderr, "lucernad: %s\n", error.what());
    return 1;
  }
}

// lucernad: the server program.
#include <fmt/core.h>
#include <pthread.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <future>
#include <thread>

#include "server/rpc/server.h"

namespace {

// Ends the thread that waits for signals.
constexpr int kWake = SIGUSR1;

/// Signals are waited for on a thread of its own; nothing runs in a signal handler.
class Signals {
 public:
  /// To be made before any other thread, which then inherits the mask.
  Signals() {
    std::signal(SIGPIPE, SIG_IGN);
    sigemptyset(&set_);
    for (const int s : {SIGTERM, SIGINT, kWake}) sigaddset(&set_, s);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    thread_ = std::thread([this] {
      int signal = 0;
      sigwait(&set_, &signal);
      if (signal != kWake) {
        spdlog::info("got {}", signal == SIGTERM ? "SIGTERM" : "SIGINT");
      }
      stop_.request_stop();
      told_.set_value();
    });
  }
  ~Signals() {
    pthread_kill(thread_.native_handle(), kWake);
    thread_.join();
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  std::stop_token stop() const { return stop_.get_token(); }
  /// Returns when the process was told to end.
  void wait() { told_.get_future().wait(); }

 private:
  sigset_t set_{};
  std::stop_source stop_;
  std::promise<void> told_;
  std::thread thread_;
};

int serve(const lucerna::rpc::ServerOptions& options, std::chrono::seconds drain_time) {
  Signals signals;
  const auto server = lucerna::rpc::Server::start(options, signals.stop());
  if (!server.ok()) {
    // Told to end before it began: that is no failure.
    if (signals.stop().stop_requested()) return 0;
    fmt::print(stderr, "lucernad: {}\n", std::string(server.status().message()));
    return 1;
  }
  fmt::print("listening on {}\n", (*server)->address());
  std::fflush(stdout);
  signals.wait();
  spdlog::info("draining for at most {} s", drain_time.count());
  (*server)->drain(drain_time);
  return 0;
}

int run(int argc, char** argv) {
  lucerna::rpc::ServerOptions options;
  options.version = LUCERNA_VERSION;
  int drain_seconds = 30;

  CLI::App app("Lucerna's server: answers questions about the light in scenes, over gRPC.");
  app.set_version_flag("--version", "lucernad " LUCERNA_VERSION);
  app.option_defaults()->always_capture_default();
  app.footer("Example:\n  lucernad --scene-root scenes --load room.pbrt");
  app.add_option("--listen", options.listen, "Where to listen; port 0: a free one")
      ->type_name("HOST:PORT");
  app.add_option("--scene-root", options.scenes.root, "The directory that scenes are loaded from")
      ->type_name("DIR");
  app.add_option("--load", options.load, "Load this scene before serving; may be repeated")
      ->type_name("PATH")
      ->expected(1)
      ->take_all();
  app.add_option("--threads", options.lanes.threads, "Compute threads; 0: one for each processor")
      ->check(CLI::Range(0, 1024));
  app.add_option("--isa", options.scenes.isa, "Pin the kernels: sse2, sse4.2, avx, avx2 or avx512");
  app.add_option("--max-batch-items", options.limits.max_batch_items, "Items of one batch")
      ->check(CLI::Range(1024U, 1U << 24));
  app.add_option("--max-tile-pixels", options.limits.max_tile_pixels, "Pixels of one tile")
      ->check(CLI::Range(1U, 1U << 26));
  app.add_option("--max-samples", options.limits.max_samples,
                 "Samples for each pixel or item of one request")
      ->check(CLI::Range(1U, 1U << 30));
  app.add_option("--max-message-bytes", options.limits.max_message_bytes, "Bytes of one message")
      ->check(CLI::Range(std::uint64_t{1} << 20, std::uint64_t{2147483647}));
  app.add_option("--memory-budget", options.scenes.memory_budget_bytes,
                 "Memory of all scenes, as 8GiB; 0: no limit.  To make room, scenes that nobody "
                 "leases go, the longest unused first")
      ->transform(CLI::AsSizeValue(false))
      ->type_name("BYTES");
  app.add_option("--max-lease", options.scenes.max_lease_s, "The longest lease of a scene [s]")
      ->check(CLI::Range(1.0, 1e9));
  app.add_option("--asset-dir", options.assets.directory,
                 "Where uploaded files are kept, for the next start too; default: a temporary "
                 "directory")
      ->type_name("DIR");
  app.add_option("--asset-budget", options.assets.budget_bytes,
                 "Disk space of uploaded files; the longest unneeded go first")
      ->transform(CLI::AsSizeValue(false))
      ->type_name("BYTES");
  app.add_option("--max-asset-bytes", options.assets.max_asset_bytes, "Size of one uploaded file")
      ->transform(CLI::AsSizeValue(false))
      ->type_name("BYTES");
  app.add_option("--interactive-queue", options.lanes.interactive_queue,
                 "Small queries that may wait")
      ->check(CLI::Range(1U, 1U << 20));
  app.add_option("--bulk-queue", options.lanes.bulk_queue, "Renders and loads that may wait")
      ->check(CLI::Range(1U, 1U << 20));
  app.add_option("--drain-seconds", drain_seconds, "How long calls may run on after SIGTERM")
      ->check(CLI::Range(0, 86400));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  spdlog::set_default_logger(spdlog::stderr_logger_mt("lucernad"));
  return serve(options, std::chrono::seconds(drain_seconds));
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

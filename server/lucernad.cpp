// lucernad: the server program.
#include <fmt/core.h>
#include <pthread.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/monitor/call_log.h"
#include "server/monitor/log_format.h"
#include "server/monitor/log_limit.h"
#include "server/rpc/server.h"

namespace {

// Ends the thread that waits for signals.
constexpr int kWake = SIGUSR1;

/// Waits for signals on a thread of its own.  Nothing runs in a signal handler.
class Signals {
 public:
  /// Construct this before any other thread, because threads inherit the signal mask.
  Signals() {
    std::signal(SIGPIPE, SIG_IGN);
    sigemptyset(&set_);
    for (const int s : {SIGTERM, SIGINT, kWake}) sigaddset(&set_, s);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    thread_ = std::thread([this] {
      int signal = 0;
      sigwait(&set_, &signal);
      if (signal != kWake) {
        spdlog::info(signal == SIGTERM ? "got SIGTERM" : "got SIGINT");
      }
      stop_.request_stop();
      signalled_.set_value();
    });
  }
  ~Signals() {
    pthread_kill(thread_.native_handle(), kWake);
    thread_.join();
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  std::stop_token stop() const { return stop_.get_token(); }
  /// Returns after SIGTERM or SIGINT.
  void wait() { signalled_.get_future().wait(); }

 private:
  sigset_t set_{};
  std::stop_source stop_;
  std::promise<void> signalled_;
  std::thread thread_;
};

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

/// How the server logs.
struct LogOptions {
  std::string format = "text", level = "info";
  std::uint64_t lines_per_second = 1000;
};

/// Directs all lines to stderr in this form.  Returns the log of calls.
std::shared_ptr<lucerna::monitor::CallLog> start_log(const LogOptions& options) {
  using lucerna::monitor::LogFormat;
  const LogFormat format = options.format == "json" ? LogFormat::kJson : LogFormat::kText;
  const spdlog::level::level_enum level = spdlog::level::from_str(options.level);
  // The lines of calls have a limit of their own, so they never displace the server's other lines.
  const auto limit = [&] {
    return std::make_shared<lucerna::monitor::LogLimit>(options.lines_per_second);
  };
  const auto out = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  out->set_formatter(lucerna::monitor::make_formatter(format));
  const auto logger =
      std::make_shared<spdlog::logger>("lucernad", lucerna::monitor::limited(out, limit()));
  logger->set_level(level);
  spdlog::set_default_logger(logger);
  return std::make_shared<lucerna::monitor::CallLog>(out, format, level, limit());
}

int serve(const lucerna::rpc::ServerOptions& options, std::chrono::seconds drain_time) {
  Signals signals;
  const auto server = lucerna::rpc::Server::start(options, signals.stop());
  if (!server.ok()) {
    // A signal before the server is ready is not a failure.
    if (signals.stop().stop_requested()) return 0;
    fmt::print(stderr, "lucernad: {}\n", std::string(server.status().message()));
    return 1;
  }
  log_start(options, **server);
  if (!(*server)->metrics_address().empty())
    fmt::print("metrics on http://{}/metrics\n", (*server)->metrics_address());
  fmt::print("listening on {}\n", (*server)->address());
  std::fflush(stdout);
  signals.wait();
  spdlog::info(fmt::format("draining for at most {} s", drain_time.count()));
  (*server)->drain(drain_time);
  spdlog::info("ended");
  return 0;
}

/// The command line.  It uses few types of options, because each takes a second to compile.
class Arguments {
 public:
  Arguments() : app_("Lucerna's server: answers queries about the light in scenes, over gRPC.") {
    app_.set_version_flag("--version", "lucernad " LUCERNA_VERSION);
    app_.option_defaults()->always_capture_default();
    app_.footer("Example:\n  lucernad --scene-root scenes --load room.pbrt");
    add("--listen", options_.listen, "HOST:PORT",
        "Address to listen on; port 0 chooses a free port");
    add("--scene-root", options_.scenes.root, "DIR", "Directory of the scenes");
    app_.add_option("--load", options_.load, "Load this scene before serving; may be repeated")
        ->type_name("PATH")
        ->expected(1)
        ->take_all();
    add("--threads", threads_, 0, 1024, "Compute threads; 0: one for each processor");
    add("--isa", options_.scenes.isa, "TEXT",
        "Instruction set of the kernels: sse2, sse4.2, avx, avx2 or avx512");
    add("--max-batch-items", batch_items_, 1024, 1U << 24, "Most items of one batch");
    add("--max-tile-pixels", tile_pixels_, 1, 1U << 26, "Most pixels of one tile");
    add("--max-samples", samples_, 1, 1U << 30,
        "Most samples for each pixel or item of one request");
    add("--max-message-bytes", options_.limits.max_message_bytes, 1U << 20, 2147483647,
        "Most bytes of one message");
    add_size("--memory-budget", options_.scenes.memory_budget_bytes,
             "Memory of all scenes, such as 8GiB; 0: no limit.  Least recently used scenes without "
             "a lease are unloaded first");
    add_size("--texture-memory", options_.scenes.texture_bytes,
             "Memory of the pictures on the surfaces of a scene; 0: no limit.  Larger pictures are "
             "halved until they fit");
    app_.add_option("--max-lease", options_.scenes.max_lease_s, "The longest lease of a scene [s]")
        ->check(CLI::Range(1.0, 1e9));
    add("--asset-dir", options_.assets.directory, "DIR",
        "Directory of uploaded files, kept for the next start; default: a temporary directory");
    add_size("--asset-budget", options_.assets.budget_bytes,
             "Disk space of uploaded files.  Least recently used files are deleted first");
    add_size("--max-asset-bytes", options_.assets.max_asset_bytes,
             "Largest size of one uploaded file");
    add("--interactive-queue", interactive_queue_, 1, 1U << 20,
        "Most queries of less than 0.1 s that may wait");
    add("--bulk-queue", bulk_queue_, 1, 1U << 20,
        "Most renders, loads and longer queries that may wait");
    add("--metrics", options_.metrics, "HOST:PORT",
        "Address of the metrics for Prometheus, without encryption; default: no metrics");
    app_.add_option("--max-call-seconds", options_.max_call_s,
                    "Longest computation of a call without a deadline [s]; 0: no limit")
        ->check(CLI::Range(0.0, 1e9));
    app_.add_option("--log-format", log_.format, "Form of the log: text, or json (JSON lines)")
        ->check(CLI::IsMember({"text", "json"}));
    app_.add_option("--log-level", log_.level, "Least level of the lines in the log")
        ->check(CLI::IsMember({"debug", "info", "warning", "error", "off"}));
    add("--log-lines", log_.lines_per_second, 0, 1U << 20,
        "Most lines of the log in a second, of calls and of other lines each; 0: no limit");
    add("--drain-seconds", drain_seconds_, 0, 86400,
        "How long calls may continue after SIGTERM [s]");
  }

  /// Nothing if the program should serve; else its exit code.
  std::optional<int> parse(int argc, char** argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
      if (e.get_exit_code() == 0) return app_.exit(e);  // --help, --version
      fmt::print(stderr, "lucernad: {}\nlucernad --help lists the options\n", e.what());
      return 2;
    }
    return std::nullopt;
  }

  lucerna::rpc::ServerOptions options() const {
    lucerna::rpc::ServerOptions options = options_;
    options.version = LUCERNA_VERSION;
    options.lanes.threads = static_cast<int>(threads_);
    options.lanes.interactive_queue = static_cast<std::uint32_t>(interactive_queue_);
    options.lanes.bulk_queue = static_cast<std::uint32_t>(bulk_queue_);
    options.limits.max_batch_items = static_cast<std::uint32_t>(batch_items_);
    options.limits.max_tile_pixels = static_cast<std::uint32_t>(tile_pixels_);
    options.limits.max_samples = static_cast<std::uint32_t>(samples_);
    return options;
  }
  const LogOptions& log() const { return log_; }
  std::chrono::seconds drain_time() const { return std::chrono::seconds(drain_seconds_); }

 private:
  void add(const char* name, std::string& value, const char* type, const char* help) {
    app_.add_option(name, value, help)->type_name(type);
  }
  void add(const char* name, std::uint64_t& value, std::uint64_t least, std::uint64_t most,
           const char* help) {
    app_.add_option(name, value, help)->check(CLI::Range(least, most));
  }
  void add_size(const char* name, std::uint64_t& value, const char* help) {
    app_.add_option(name, value, help)->transform(CLI::AsSizeValue(false))->type_name("BYTES");
  }

  CLI::App app_;
  lucerna::rpc::ServerOptions options_;
  LogOptions log_;
  std::uint64_t threads_ = 0, drain_seconds_ = 30;
  std::uint64_t batch_items_ = options_.limits.max_batch_items;
  std::uint64_t tile_pixels_ = options_.limits.max_tile_pixels;
  std::uint64_t samples_ = options_.limits.max_samples;
  std::uint64_t interactive_queue_ = options_.lanes.interactive_queue;
  std::uint64_t bulk_queue_ = options_.lanes.bulk_queue;
};

int run(int argc, char** argv) {
  Arguments arguments;
  if (const std::optional<int> code = arguments.parse(argc, argv)) return *code;
  const auto calls = start_log(arguments.log());
  lucerna::rpc::ServerOptions options = arguments.options();
  // The level decides whether calls are logged; without them the server collects less.
  if (spdlog::should_log(spdlog::level::info)) {
    options.on_call = [calls](const auto& record) { calls->write(record); };
    options.log_lines_left_out = [calls] { return calls->left_out(); };
  }
  return serve(options, arguments.drain_time());
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

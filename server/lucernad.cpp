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
#include <optional>
#include <string>
#include <thread>

#include "server/option_values.h"
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
    add_size("--memory-budget", options_.scenes.memory_budget_bytes, 0,
             "Memory of all scenes and loads, such as 8GiB; 0: no limit.  Least recently used "
             "scenes without "
             "a lease are unloaded first");
    add_size("--texture-memory", options_.scenes.texture_bytes, 0,
             "Memory of the pictures on the surfaces of a scene; 0: no limit.  Larger pictures are "
             "halved until they fit");
    app_.add_option("--max-lease", options_.scenes.max_lease_s, "The longest lease of a scene [s]")
        ->type_name("SECONDS")
        ->check([](const std::string& text) {
          return lucerna::check_real(text, {1, 1e9});
        });
    add("--max-scene-primitives", options_.scenes.max_primitives, 1, 1ULL << 32,
        "Most triangles, patches, curves and other shapes of a scene");
    add_size("--max-scene-bytes", options_.scenes.max_scene_bytes, 1,
             "Most bytes of the files of a scene.  Compressed files also count unpacked");
    add("--max-picture-texels", options_.scenes.max_texels, 1, 1ULL << 30,
        "Most texels of one picture");
    add("--max-include-depth", options_.scenes.max_include_depth, 1, 1000,
        "How deep .pbrt files may include each other");
    add("--max-tokens", options_.scenes.max_tokens, 1, 1ULL << 40,
        "Most words, strings and brackets of the .pbrt files of a scene");
    add("--asset-dir", options_.assets.directory, "DIR",
        "Directory of uploaded files, kept for the next start; default: a temporary directory");
    add_size("--asset-budget", options_.assets.budget_bytes, 1,
             "Disk space of uploaded files.  Least recently used files are deleted first");
    add_size("--max-asset-bytes", options_.assets.max_asset_bytes, 1,
             "Largest size of one uploaded file");
    add("--upload-timeout", upload_timeout_, 1, 86400,
        "How long an upload may send nothing before it is ended [s]");
    add("--keep-partial-uploads", keep_parts_, 0, 1'000'000'000,
        "How long the part of an interrupted upload is kept [s]");
    add("--interactive-queue", interactive_queue_, 1, 1U << 20,
        "Most queries of less than 0.1 s that may wait");
    add("--bulk-queue", bulk_queue_, 1, 1U << 20,
        "Most renders, loads and longer queries that may wait");
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
    options.assets.stall_time = std::chrono::seconds(upload_timeout_);
    options.assets.keep_parts = std::chrono::seconds(keep_parts_);
    return options;
  }
  std::chrono::seconds drain_time() const { return std::chrono::seconds(drain_seconds_); }

 private:
  void add(const char* name, std::string& value, const char* type, const char* help) {
    app_.add_option(name, value, help)->type_name(type);
  }
  void add(const char* name, std::uint64_t& value, std::uint64_t least, std::uint64_t most,
           const char* help) {
    app_.add_option(name, value, help)
        ->type_name(fmt::format("{}..{}", least, most))
        ->check([=](const std::string& text) {
          return lucerna::check_whole(text, {least, most});
        });
  }
  void add_size(const char* name, std::uint64_t& value, std::uint64_t least, const char* help) {
    // Sums of a few sizes then fit 64 bits.
    constexpr std::uint64_t kMost = std::uint64_t{1} << 60;
    app_.add_option(name, value, help)
        ->type_name("BYTES")
        ->transform(CLI::Validator(
            [=](std::string& text) {
              return lucerna::to_bytes(text, {least, kMost});
            },
            ""));
  }

  CLI::App app_;
  lucerna::rpc::ServerOptions options_;
  std::uint64_t threads_ = 0, drain_seconds_ = 30;
  std::uint64_t upload_timeout_ = static_cast<std::uint64_t>(options_.assets.stall_time.count());
  std::uint64_t keep_parts_ = static_cast<std::uint64_t>(options_.assets.keep_parts.count());
  std::uint64_t batch_items_ = options_.limits.max_batch_items;
  std::uint64_t tile_pixels_ = options_.limits.max_tile_pixels;
  std::uint64_t samples_ = options_.limits.max_samples;
  std::uint64_t interactive_queue_ = options_.lanes.interactive_queue;
  std::uint64_t bulk_queue_ = options_.lanes.bulk_queue;
};

int run(int argc, char** argv) {
  Arguments arguments;
  if (const std::optional<int> code = arguments.parse(argc, argv)) return *code;
  spdlog::set_default_logger(spdlog::stderr_logger_mt("lucernad"));
  // ISO 8601 with the zone's offset, and the level.
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z [%l] %v");
  return serve(arguments.options(), arguments.drain_time());
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

// Calls that are cancelled, that reach their deadline, or whose client is killed.
#include "tests/reliability/stopping.h"

#include <fmt/core.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "proto/common/quantile.h"
#include "tests/reliability/long_calls.h"
#include "tests/reliability/reliability_report.h"
#include "tests/reliability/stream_call.h"

namespace lucerna::reliability {
namespace {

// A server that still computes after this time does not stop.
constexpr Seconds kGiveUp(10);
// The server is idle if it computes less than kNoise in kQuiet.  gRPC's timers and the log take
// that.  What the allocator returns later does not count.
constexpr Seconds kQuiet(0.1);
constexpr double kNoise = 0.001;
// Calls are stopped at a random moment of at most their first second.
constexpr Seconds kLatest(1);

/// Processor time of the server at a moment.
struct Reading {
  Clock::time_point at;
  double cpu_s;
};

/// From a stop until the server computes nothing more.
struct UntilIdle {
  double time_s;  ///< kGiveUp if it does not stop
  double cpu_s;   ///< processor time of the server meanwhile
};

/// Works for `call` meanwhile, as a client does: otherwise gRPC may send the end of the call late.
UntilIdle until_idle(const Subject& subject, Clock::time_point stop, StreamCall* call = nullptr) {
  std::vector<Reading> readings;
  const auto last = after(stop, kGiveUp);
  for (;;) {
    readings.push_back({Clock::now(), subject.cpu_s() - subject.allocator_cpu_s()});
    const Reading& now = readings.back();
    const double first_cpu_s = readings.front().cpu_s;
    if (now.at > last) return {kGiveUp.count(), now.cpu_s - first_cpu_s};
    const auto quiet = std::find_if(readings.begin(), readings.end(),
                                    [&](const Reading& r) { return now.cpu_s - r.cpu_s < kNoise; });
    if (now.at - quiet->at >= kQuiet)
      return {std::max(0.0, Seconds(quiet->at - stop).count()), quiet->cpu_s - first_cpu_s};
    if (call != nullptr) call->work(Clock::now());
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// A process that makes the call.
class Client {
 public:
  Client(const Subject& subject, const Message& message, const std::string& file) {
    std::vector<grpc::Slice> slices;
    (void)message.bytes.Dump(&slices);
    std::ofstream out(file, std::ios::binary);
    for (const grpc::Slice& slice : slices)
      out.write(reinterpret_cast<const char*>(slice.begin()),
                static_cast<std::streamsize>(slice.size()));
    out.close();
    std::array<std::string, 5> words = {"reliability", "--endless", subject.target(),
                                        message.method, file};
    std::array<char*, 6> argv{};
    std::transform(words.begin(), words.end(), argv.begin(), [](auto& w) { return w.data(); });
    if (posix_spawn(&id_, "/proc/self/exe", nullptr, nullptr, argv.data(), environ) != 0)
      throw std::runtime_error("cannot start a client");
  }
  ~Client() { kill(); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  void kill() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    ::waitpid(std::exchange(id_, 0), nullptr, 0);
  }

 private:
  pid_t id_ = 0;
};

/// Waits until the server has computed for `time`, or for kGiveUp.
void wait_for_work(const Subject& subject, double from_cpu_s, Seconds time) {
  const auto last = after(Clock::now(), kGiveUp);
  while (subject.cpu_s() - from_cpu_s < time.count() && Clock::now() < last)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

enum class Way { kCancel, kDeadline, kKill };
constexpr std::array kWays = {Way::kCancel, Way::kDeadline, Way::kKill};

/// Stops the call after `time`.  Returns how long the server still computes.
UntilIdle stop_once(const Subject& subject, const SceneFiles& files, const LongCall& call, Way way,
                    Seconds time) {
  const Message message = call.message();
  if (way == Way::kKill) {
    const double before = subject.cpu_s();
    Client client(subject, message, files.folder() + "/request");
    wait_for_work(subject, before, time);
    client.kill();
    return until_idle(subject, Clock::now());
  }
  auto stop = after(Clock::now(), time);
  StreamCall running(make_channel(subject.target()), message,
                     way == Way::kDeadline ? std::optional(stop) : std::nullopt, call.repeated);
  running.work(stop);
  if (way == Way::kCancel) {
    running.cancel();
    stop = Clock::now();
  }
  return until_idle(subject, stop, &running);
}

}  // namespace

int run_endless(const std::string& target, const std::string& method, const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  const grpc::Slice slice(bytes.str());
  StreamCall call(make_channel(target), {method, grpc::ByteBuffer(&slice, 1)});
  while (!call.work(after(Clock::now(), kGiveUp))) {
  }
  return 0;
}

void stopping(const Settings& settings, Report& report) {
  const SceneFiles files(settings.brief ? 200 : 700);
  Subject subject(files, {"--max-batch-items", std::to_string(kManyItems), "--max-message-bytes",
                          "1GiB", "--memory-budget", "2GiB"});
  std::mt19937 random(1);
  std::vector<double> all;
  int way = 0;
  for (const LongCall& call : long_calls(subject, files)) {
    // How long the call takes if nobody stops it.
    const auto start = Clock::now();
    Seconds whole = kLatest;
    {
      StreamCall undisturbed(make_channel(subject.target()), call.message(), std::nullopt,
                             call.repeated);
      if (undisturbed.work(after(start, kLatest))) whole = Clock::now() - start;
    }
    (void)until_idle(subject, Clock::now());
    std::vector<double> times, cpu_times;
    for (int i = 0; i < (settings.brief ? 1 : 15); ++i) {
      // Clients that are killed send one message only.
      Way next = kWays[static_cast<std::size_t>(way++) % kWays.size()];
      if (next == Way::kKill && call.repeated) next = Way::kCancel;
      const Seconds time = whole * std::uniform_real_distribution(0.05, 0.95)(random);
      const UntilIdle idle = stop_once(subject, files, call, next, time);
      times.push_back(idle.time_s);
      cpu_times.push_back(idle.cpu_s);
    }
    all.insert(all.end(), times.begin(), times.end());
    report.note(call.name + ": whole call, at most 1 s", 1e3 * whole.count(), "ms");
    report.time(call.name + ": most until idle", 1e3 * quantile(times, 1), 50, "ms");
    report.note(call.name + ": most processor time until idle", 1e3 * quantile(cpu_times, 1), "ms");
  }
  report.time("all calls: until idle, p99", 1e3 * quantile(all, 0.99), 50, "ms");
  report.at_most("calls that computed for another 10 s",
                 static_cast<double>(std::count(all.begin(), all.end(), kGiveUp.count())), 0,
                 "calls");
}

}  // namespace lucerna::reliability

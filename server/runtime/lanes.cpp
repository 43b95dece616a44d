#include "server/runtime/lanes.h"

#include <fmt/core.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/runtime/parallel.h"
#include "server/runtime/scheduling.h"

namespace lucerna {
namespace {

// Two jobs of a kind run at a time.  So a short job can overtake a long one, and a job that cannot
// use all threads leaves some for the other.
constexpr int kJobsAtATime = 2;
// Further jobs of clients that have none running.
constexpr int kExtraJobs = 2;
// Large enough that an interactive thread runs at once when it wakes.
constexpr int kBulkNiceness = 10;
// Computations and their steps share places.
constexpr std::size_t kPlaces = 2;

std::chrono::nanoseconds from_seconds(double s) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(s));
}

absl::Status why_not_to_run(const LaneJob& job) {
  if (job.stop.stop_requested()) return absl::CancelledError("cancelled before the work started");
  if (job.deadline == LaneJob::Clock::time_point::max()) return absl::OkStatus();
  const auto now = LaneJob::Clock::now();
  if (job.deadline <= now) {
    return absl::DeadlineExceededError("the deadline passed before the work started");
  }
  // A larger number would overflow the clock.
  constexpr double kMostSeconds = 1e9;
  if (job.least_s > 0 && job.deadline - now < from_seconds(std::min(job.least_s, kMostSeconds))) {
    return absl::DeadlineExceededError(
        fmt::format("the work was not started: it takes about {:.3g} s, and the deadline is {:.3g} "
                    "s away",
                    job.least_s, std::chrono::duration<double>(job.deadline - now).count()));
  }
  return absl::OkStatus();
}

/// Whether the job will end before its deadline, if it takes `caution` times what is expected.
bool in_time(const LaneJob& job, double caution) {
  if (job.deadline == LaneJob::Clock::time_point::max() || job.expected_s <= 0) return true;
  const std::chrono::duration<double> left = job.deadline - LaneJob::Clock::now();
  return left.count() >= caution * job.expected_s;
}

/// Sets how the operating system schedules each thread that enters an arena.  oneTBB's workers move
/// between the arenas.  If the process may not lower a niceness, they keep the larger one.
class ArenaScheduling : public tbb::task_scheduler_observer {
 public:
  ArenaScheduling(tbb::task_arena& arena, int niceness, TimeSlice slice)
      : tbb::task_scheduler_observer(arena), niceness_(niceness), slice_(slice) {
    observe(true);
  }
  ~ArenaScheduling() override { observe(false); }
  ArenaScheduling(const ArenaScheduling&) = delete;
  ArenaScheduling& operator=(const ArenaScheduling&) = delete;

  void on_scheduler_entry(bool) override {
    set_thread_niceness(niceness_);
    set_time_slice(slice_);
  }

 private:
  int niceness_;
  TimeSlice slice_;
};

struct QueueOptions {
  const char* name;
  std::uint32_t limit;
  int threads;  ///< of one loop
  tbb::task_arena::priority priority;
  int niceness;  ///< in addition to that of the thread that makes the lanes
  TimeSlice slice;
  bool kinds;  ///< each kind of job has its own places
};

class Queue {
 public:
  explicit Queue(const QueueOptions& options)
      : options_(options),
        threads_count_(options.kinds ? static_cast<int>(kPlaces) * (kJobsAtATime + kExtraJobs)
                                     : kJobsAtATime),
        arena_(options.threads - 1 + threads_count_, static_cast<unsigned>(threads_count_),
               options.priority),
        scheduling_(arena_, thread_niceness() + options.niceness, options.slice) {
    for (int i = 0; i < threads_count_; ++i) {
      threads_.emplace_back([this] {
        const SharedProcessors shared(busy_, options_.threads);
        arena_.execute([this] { work(); });
      });
    }
  }

  ~Queue() {
    std::vector<Waiting> left;
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
      for (auto& [name, client] : clients_) {
        for (Line& line : client.lines) {
          std::move(line.begin(), line.end(), std::back_inserter(left));
          line.clear();
        }
      }
      load_.waiting = 0;
    }
    wake_.notify_all();
    for (Waiting& w : left) {
      answer(w, absl::UnavailableError("the server is shutting down"));
    }
    threads_.clear();  // joins
  }
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  absl::Status push(LaneJob job, bool bounded) {
    std::vector<Waiting> swept;
    absl::Status status;
    {
      const std::lock_guard lock(mutex_);
      if (bounded && load_.waiting >= options_.limit) sweep(swept);
      if (ended_) {
        status = absl::UnavailableError("the server is shutting down");
        if (!bounded) swept.push_back({std::move(job), LaneJob::Clock::now(), 0});
      } else if (bounded && load_.waiting >= options_.limit) {
        status = absl::ResourceExhaustedError(fmt::format(
            "{} requests wait in the {} lane, its limit", options_.limit, options_.name));
      } else {
        append(std::move(job));
      }
    }
    wake_.notify_one();
    for (Waiting& w : swept) {
      const absl::Status why = why_not_to_run(w.job);
      answer(w, why.ok() ? absl::UnavailableError("the server is shutting down") : why);
    }
    return status;
  }

  LaneLoad load() const {
    const std::lock_guard lock(mutex_);
    return load_;
  }

 private:
  struct Waiting {
    LaneJob job;
    LaneJob::Clock::time_point since;
    /// A connection has at most one waiting job in a round.
    std::uint64_t round;
  };
  /// Ordered by round.
  struct Line : std::deque<Waiting> {
    std::uint64_t next_round = 0;  // after the one that was served last
  };
  /// The jobs of one client.
  struct Client {
    std::array<Line, 3> lines;  // by JobKind
    std::array<int, kPlaces> running{};
    /// The client with the least number is next.  It grows with each turn and each arrival.
    std::uint64_t turn = 0;
    /// The line of computations that is next.
    std::size_t next_line = kWhole;

    bool waits() const {
      return std::any_of(lines.begin(), lines.end(), [](const Line& l) { return !l.empty(); });
    }
    bool runs() const { return running[0] + running[1] > 0; }
  };
  static constexpr auto kLoads = static_cast<std::size_t>(JobKind::kLoad);
  static constexpr auto kSteps = static_cast<std::size_t>(JobKind::kStep);
  static constexpr auto kWhole = static_cast<std::size_t>(JobKind::kComputation);
  using Clients = std::map<std::string, Client, std::less<>>;
  /// A job that may run now.
  struct Choice {
    Clients::iterator client;
    std::size_t line;
  };

  static void answer(Waiting& w, absl::Status status) {
    const std::chrono::duration<double> waited = LaneJob::Clock::now() - w.since;
    w.job.run({std::move(status), std::max(0.0, waited.count())});
  }

  static std::size_t place_of(std::size_t line) { return line == kLoads ? 0 : 1; }

  void append(LaneJob job) {
    Client& client = clients_[job.client];
    // A client that was away gets no turns for that time.
    if (!client.waits()) client.turn = ++turn_;
    Line& line = client.lines[options_.kinds ? static_cast<std::size_t>(job.kind) : kWhole];
    std::uint64_t round = line.next_round;
    const auto last = std::find_if(line.rbegin(), line.rend(), [&](const Waiting& w) {
      return w.job.connection == job.connection;
    });
    if (last != line.rend()) round = std::max(round, last->round + 1);
    const auto place = std::find_if(line.rbegin(), line.rend(),
                                    [&](const Waiting& w) { return w.round <= round; });
    line.insert(place.base(), {std::move(job), LaneJob::Clock::now(), round});
    ++load_.waiting;
  }

  /// Removes jobs that were cancelled or that cannot meet their deadline.
  void sweep(std::vector<Waiting>& out) {
    for (auto client = clients_.begin(); client != clients_.end();) {
      for (Line& line : client->second.lines) {
        const auto dead = std::stable_partition(
            line.begin(), line.end(), [](const Waiting& w) { return why_not_to_run(w.job).ok(); });
        load_.waiting -= static_cast<std::size_t>(line.end() - dead);
        std::move(dead, line.end(), std::back_inserter(out));
        line.erase(dead, line.end());
      }
      client = is_idle(client->second) ? clients_.erase(client) : std::next(client);
    }
  }

  bool may_run(const Client& client, std::size_t place) const {
    return running_[place] < kJobsAtATime || (options_.kinds && client.running[place] == 0 &&
                                              running_[place] < kJobsAtATime + kExtraJobs);
  }

  /// The line of the client whose first job may run now; nothing if there is none.
  std::optional<std::size_t> line_of(const Client& client) const {
    const std::size_t other = client.next_line == kWhole ? kSteps : kWhole;
    for (const std::size_t line : {kLoads, client.next_line, other}) {
      if (!client.lines[line].empty() && may_run(client, place_of(line))) return line;
    }
    return std::nullopt;
  }

  /// The job of the line that runs next.
  static Line::iterator next_of(Line& line) {
    for (const double caution : {2.0, 1.0}) {
      const auto next = std::find_if(line.begin(), line.end(), [&](const Waiting& w) {
        return in_time(w.job, caution) || !why_not_to_run(w.job).ok();
      });
      if (next != line.end()) return next;
    }
    return line.begin();
  }

  std::optional<Choice> choose() {
    std::optional<Choice> best;
    for (auto client = clients_.begin(); client != clients_.end(); ++client) {
      if (best && best->client->second.turn <= client->second.turn) continue;
      if (const auto line = line_of(client->second)) best = {client, *line};
    }
    return best;
  }

  static bool is_idle(const Client& client) { return !client.waits() && !client.runs(); }

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      std::optional<Choice> choice;
      wake_.wait(lock, [&] { return ended_ || (choice = choose()).has_value(); });
      if (ended_) return;
      Client& client = choice->client->second;
      const std::size_t line = choice->line, place = place_of(line);
      const auto chosen = next_of(client.lines[line]);
      Waiting next = std::move(*chosen);
      client.lines[line].erase(chosen);
      client.lines[line].next_round = std::max(client.lines[line].next_round, next.round + 1);
      client.turn = ++turn_;
      if (line != kLoads) client.next_line = line == kWhole ? kSteps : kWhole;
      --load_.waiting;
      ++load_.running;
      ++busy_;
      ++running_[place];
      ++client.running[place];
      lock.unlock();
      answer(next, why_not_to_run(next.job));
      next = {};  // release the job's resources while it still counts as running
      lock.lock();
      --load_.running;
      --busy_;
      --running_[place];
      --client.running[place];  // a client with running jobs is never erased
      if (is_idle(client)) clients_.erase(choice->client);
    }
  }

  QueueOptions options_;
  int threads_count_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  Clients clients_;
  std::uint64_t turn_ = 0;  // the last that was given
  std::array<int, kPlaces> running_{};
  LaneLoad load_;
  std::atomic<int> busy_ = 0;  // load_.running, for loops
  bool ended_ = false;
  tbb::task_arena arena_;
  ArenaScheduling scheduling_;
  std::vector<std::jthread> threads_;
};

int thread_count(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

struct Lanes::State {
  explicit State(const LaneOptions& o)
      : threads(thread_count(o.threads)),
        // oneTBB counts the calling thread, so there are `threads` - 1 workers.
        control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        interactive({.name = "interactive",
                     .limit = o.interactive_queue,
                     .threads = threads,
                     .priority = tbb::task_arena::priority::high,
                     .niceness = 0,
                     .slice = TimeSlice::kShort,
                     .kinds = false}),
        bulk({.name = "bulk",
              .limit = o.bulk_queue,
              .threads = threads,
              .priority = tbb::task_arena::priority::low,
              .niceness = kBulkNiceness,
              .slice = TimeSlice::kDefault,
              .kinds = true}) {}
  Queue& queue(Lane lane) { return lane == Lane::kInteractive ? interactive : bulk; }

  int threads;
  tbb::global_control control;
  Queue interactive, bulk;
};

Lanes::Lanes(const LaneOptions& options) : state_(std::make_unique<State>(options)) {}
Lanes::~Lanes() = default;

absl::Status Lanes::submit(Lane lane, LaneJob job) {
  return state_->queue(lane).push(std::move(job), true);
}

void Lanes::resume(Lane lane, LaneJob job) {
  // If the lanes ended, the job was called with UNAVAILABLE.
  (void)state_->queue(lane).push(std::move(job), false);
}

int Lanes::threads() const { return state_->threads; }
LaneLoad Lanes::load(Lane lane) const { return state_->queue(lane).load(); }
std::size_t Lanes::pending(Lane lane) const {
  const LaneLoad load = this->load(lane);
  return load.waiting + load.running;
}

}  // namespace lucerna

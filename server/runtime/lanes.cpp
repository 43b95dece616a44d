#include "server/runtime/lanes.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace lucerna {
namespace {

// Two jobs of a lane run at a time.  So a short job can overtake a long one, and a job that cannot
// use all threads leaves some for the other.
constexpr int kJobsAtATime = 2;
// Large enough that an interactive thread runs at once when it wakes.
constexpr int kBulkNiceness = 10;

absl::Status why_not_to_run(const LaneJob& job) {
  if (job.stop.stop_requested()) return absl::CancelledError("cancelled before the work started");
  if (job.deadline <= LaneJob::Clock::now()) {
    return absl::DeadlineExceededError("the deadline passed before the work started");
  }
  return absl::OkStatus();
}

class Queue {
 public:
  Queue(const char* name, std::uint32_t limit, int threads, tbb::task_arena::priority priority,
        int niceness)
      : name_(name), limit_(limit), arena_(threads - 1 + kJobsAtATime, kJobsAtATime, priority) {
    for (int i = 0; i < kJobsAtATime; ++i) {
      threads_.emplace_back([this, niceness] {
        // On Linux, niceness is a property of the thread.  If this fails, both lanes have the same
        // priority.
        if (niceness > 0) (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);
        arena_.execute([this] { work(); });
      });
    }
  }

  ~Queue() {
    std::deque<Waiting> left;
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
      left.swap(waiting_);
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
      if (bounded && waiting_.size() >= limit_) sweep(swept);
      if (ended_) {
        status = absl::UnavailableError("the server is shutting down");
        if (!bounded) swept.push_back({std::move(job), LaneJob::Clock::now()});
      } else if (bounded && waiting_.size() >= limit_) {
        status = absl::ResourceExhaustedError(
            fmt::format("{} requests wait in the {} lane, its limit", limit_, name_));
      } else {
        waiting_.push_back({std::move(job), LaneJob::Clock::now()});
      }
    }
    wake_.notify_one();
    for (Waiting& w : swept) {
      const absl::Status why = why_not_to_run(w.job);
      answer(w, why.ok() ? absl::UnavailableError("the server is shutting down") : why);
    }
    return status;
  }

  std::size_t pending() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size() + running_;
  }

 private:
  struct Waiting {
    LaneJob job;
    LaneJob::Clock::time_point since;
  };

  static void answer(Waiting& w, absl::Status status) {
    const std::chrono::duration<double> waited = LaneJob::Clock::now() - w.since;
    w.job.run({std::move(status), std::max(0.0, waited.count())});
  }

  /// Removes jobs that were cancelled or whose deadline has passed.
  void sweep(std::vector<Waiting>& out) {
    const auto dead = std::stable_partition(waiting_.begin(), waiting_.end(), [](const Waiting& w) {
      return why_not_to_run(w.job).ok();
    });
    std::move(dead, waiting_.end(), std::back_inserter(out));
    waiting_.erase(dead, waiting_.end());
  }

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
      if (ended_) return;
      Waiting next = std::move(waiting_.front());
      waiting_.pop_front();
      ++running_;
      lock.unlock();
      answer(next, why_not_to_run(next.job));
      next = {};  // release the job's resources while it still counts as running
      lock.lock();
      --running_;
    }
  }

  const char* name_;
  std::size_t limit_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Waiting> waiting_;
  std::size_t running_ = 0;
  bool ended_ = false;
  tbb::task_arena arena_;
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
        interactive("interactive", o.interactive_queue, threads, tbb::task_arena::priority::high,
                    0),
        bulk("bulk", o.bulk_queue, threads, tbb::task_arena::priority::low, kBulkNiceness) {}
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
std::size_t Lanes::pending(Lane lane) const { return state_->queue(lane).pending(); }

}  // namespace lucerna

#include "lucerna/client/job.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <unordered_map>
#include <utility>
#include <variant>

#include "client/job_schedule.h"

namespace lucerna::client {
namespace {

using Clock = std::chrono::steady_clock;
using ServerId = JobSchedule::ServerId;
using AttemptId = JobSchedule::AttemptId;

constexpr std::chrono::seconds kAskForServers(2);
// Calls that only ask; who takes longer is not there.
constexpr std::chrono::seconds kPatience(10);

CallOptions soon(CallOptions call) {
  call.deadline = std::min<CallOptions::Clock::time_point>(call.deadline,
                                                           CallOptions::Clock::now() + kPatience);
  return call;
}

/// A server that has the scene.
struct Ready {
  Client client;
  std::string fingerprint;
  std::string scene_id, lease_id;
};

struct Listed {
  absl::StatusOr<std::vector<std::string>> targets;
};
struct PreparedEvent {
  ServerId server;
  absl::StatusOr<Ready> answer;
};
struct Renewed {
  ServerId server;
  absl::Status answer;
};
struct Finished {
  AttemptId attempt;
  absl::StatusOr<Work::Result> answer;
};
using Event = std::variant<Listed, PreparedEvent, Renewed, Finished>;

/// What other threads tell the job's own.
class Events {
 public:
  void post(Event event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(std::move(event));
    changed_.notify_one();
  }
  void wake() {
    const std::lock_guard lock(mutex_);
    woken_ = true;
    changed_.notify_one();
  }
  /// Those that came since; waits for one until `until`.
  std::vector<Event> wait(Clock::time_point until) {
    std::unique_lock lock(mutex_);
    const auto any = [this] { return woken_ || !events_.empty(); };
    if (until == Clock::time_point::max()) {
      changed_.wait(lock, any);
    } else {
      changed_.wait_until(lock, until, any);
    }
    woken_ = false;
    return std::exchange(events_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Event> events_;
  bool woken_ = false;
};

/// Runs a schedule over gRPC.  All but the posting of events happens in the thread of run().
class Job final : JobSchedule::Channel {
 public:
  Job(Work& work, const JobOptions& options)
      : work_(work),
        options_(options),
        schedule_(work.size(),
                  {.window = std::max(options.window, 1),
                   .allow_mixed = options.allow_mixed,
                   .seed = std::random_device{}()},
                  *this, begun_) {}

  absl::StatusOr<JobReport> run() {
    const std::stop_callback stopped(options_.call.stop, [this] { events_.wake(); });
    const std::jthread lister([this](const std::stop_token& stop) { ask_for_servers(stop); });
    while (!schedule_.over() && accepted_.ok()) {
      const Clock::time_point due = schedule_.advance(Clock::now());
      for (Event& event : events_.wait(std::min(due, deadline())))
        std::visit([this](auto& e) { take(e); }, event);
      if (options_.call.stop.stop_requested())
        schedule_.end(absl::CancelledError("the job was stopped"));
      if (CallOptions::Clock::now() >= options_.call.deadline)
        schedule_.end(
            absl::DeadlineExceededError("the deadline passed before all pieces were done"));
    }
    if (!accepted_.ok()) return accepted_;
    if (!schedule_.status().ok()) return schedule_.status();
    return JobReport{schedule_.fingerprints(), schedule_.duplicates()};
  }

  /// Stops what is under way, and waits for it to be over: it holds on to the work.
  ~Job() {
    preparing_.request_stop();
    for (auto& [attempt, stop] : attempts_) stop.request_stop();
    while (under_way_ > 0) {
      for (const Event& event : events_.wait(Clock::time_point::max()))
        under_way_ -= std::holds_alternative<Listed>(event) ? 0 : 1;
    }
  }

 private:
  struct Server {
    std::optional<Ready> ready;
    std::jthread preparing;
  };

  /// Of the job as a whole, by the clock that waiting goes by.
  Clock::time_point deadline() const {
    if (options_.call.deadline == CallOptions::Clock::time_point::max())
      return Clock::time_point::max();
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(options_.call.deadline -
                                                                      CallOptions::Clock::now());
  }
  CallOptions call(const std::stop_source& stop) const {
    return {.deadline = options_.call.deadline, .stop = stop.get_token()};
  }

  void ask_for_servers(const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      events_.post(Listed{options_.servers()});
      stopped.wait_for(lock, stop, kAskForServers, [] { return false; });
    }
  }

  // What the schedule has done.

  void prepare(ServerId id, const std::string& target) override {
    ++under_way_;
    Server& server = servers_[id];
    server.ready.reset();
    // In a thread of its own, since it may take as long as the upload of a scene.
    server.preparing = std::jthread([this, id, target] {
      events_.post(PreparedEvent{id, make_ready(target, call(preparing_))});
    });
  }

  absl::StatusOr<Ready> make_ready(const std::string& target, const CallOptions& call) const {
    auto client = Client::connect({.target = target, .retry = false});
    if (!client.ok()) return client.status();
    const auto info = client->get_server_info({}, soon(call));
    if (!info.ok()) return info.status();
    auto loaded = options_.load(*client, call);
    if (!loaded.ok()) return loaded.status();
    return Ready{*std::move(client), info->fingerprint().digest(), loaded->scene_id(),
                 loaded->lease_id()};
  }

  void renew(ServerId id) override {
    ++under_way_;
    const Ready& ready = *servers_[id].ready;
    v1::RenewLeaseRequest request;
    request.set_scene_id(ready.scene_id);
    request.set_lease_id(ready.lease_id);
    request.set_lease_s(static_cast<double>(kJobLease.count()));
    ready.client.renew_lease(request, soon(call(preparing_)), [this, id](const auto& answer) {
      events_.post(Renewed{id, answer.status()});
    });
  }

  void start(AttemptId attempt, ServerId id, std::size_t piece) override {
    ++under_way_;
    const Ready& ready = *servers_[id].ready;
    work_.start(piece, ready.client, ready.scene_id, call(attempts_[attempt]),
                [this, attempt](absl::StatusOr<Work::Result> answer) {
                  events_.post(Finished{attempt, std::move(answer)});
                });
  }

  void cancel(AttemptId attempt) override { attempts_.at(attempt).request_stop(); }

  void say(const std::string& event) override {
    if (options_.on_event) options_.on_event(event);
  }

  // What others tell.

  void take(Listed& event) { schedule_.list(event.targets, Clock::now()); }

  void take(PreparedEvent& event) {
    --under_way_;
    absl::StatusOr<JobSchedule::Prepared> answer;
    if (event.answer.ok()) {
      answer = JobSchedule::Prepared{event.answer->fingerprint, event.answer->scene_id};
      servers_[event.server].ready.emplace(*std::move(event.answer));
    } else {
      answer = event.answer.status();
    }
    schedule_.prepared(event.server, answer, Clock::now());
    progress();
  }

  void take(Renewed& event) {
    --under_way_;
    schedule_.renewed(event.server, event.answer, Clock::now());
  }

  void take(Finished& event) {
    --under_way_;
    const std::size_t piece = schedule_.pieces().attempt(event.attempt).piece;
    attempts_.erase(event.attempt);
    // First the server gets its next piece, then this one is taken.
    if (schedule_.finished(event.attempt, event.answer.status(), Clock::now()) && accepted_.ok())
      accepted_ = work_.accept(piece, *std::move(event.answer));
    progress();
  }

  void progress() const {
    if (!options_.on_progress) return;
    const JobPieces& pieces = schedule_.pieces();
    options_.on_progress(
        {pieces.done_count(), pieces.count(), schedule_.answering(), Clock::now() - begun_});
  }

  Work& work_;
  const JobOptions& options_;
  const Clock::time_point begun_ = Clock::now();
  Events events_;
  std::stop_source preparing_;
  std::unordered_map<AttemptId, std::stop_source> attempts_;
  std::size_t under_way_ = 0;  // answers that are still to come
  absl::Status accepted_;
  JobSchedule schedule_;
  std::map<ServerId, Server> servers_;  // the last: its threads use the above
};

}  // namespace

absl::StatusOr<JobReport> run_job(Work& work, const JobOptions& options) {
  return Job(work, options).run();
}

}  // namespace lucerna::client

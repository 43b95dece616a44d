#include "lucerna/client/job.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <unordered_map>
#include <utility>
#include <variant>

#include "client/library/job_schedule.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {
namespace {

using Clock = std::chrono::steady_clock;
using ServerId = JobSchedule::ServerId;
using AttemptId = JobSchedule::AttemptId;

constexpr std::chrono::seconds kListInterval(2);
// Time limit of quick calls.  A server that does not answer in this time counts as absent.
constexpr std::chrono::seconds kShortCallTime(10);

/// A server that holds the scene.
struct Ready {
  Client client;
  v1::GetServerInfoResponse info;
  v1::SceneSummary scene;
  std::string lease_id;
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
  absl::StatusOr<DistributedWork::Result> answer;
};
using Event = std::variant<Listed, PreparedEvent, Renewed, Finished>;

/// Events from other threads to the thread of the job.
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
  /// Returns the events since the last call.  If there are none, waits for one until `until`.
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

/// Runs a schedule over gRPC.  Other threads only post events; everything else happens in the
/// thread of run().
class JobRunner final : JobSchedule::Channel {
 public:
  JobRunner(DistributedWork& work, const JobOptions& options)
      : work_(work),
        options_(options),
        schedule_({.window = std::max(options.window, 1),
                   .allow_mixed = options.allow_mixed,
                   .seed = std::random_device{}()},
                  *this, begun_) {}

  absl::StatusOr<JobReport> run() {
    const std::stop_callback stopped(options_.call.stop, [this] { events_.wake(); });
    const std::jthread lister([this](const std::stop_token& stop) { list_servers(stop); });
    while (!schedule_.over() && work_status_.ok()) {
      const Clock::time_point due = schedule_.advance(Clock::now());
      for (Event& event : events_.wait(std::min({due, deadline(), end_of_patience()})))
        std::visit([this](auto& e) { take(e); }, event);
      if (options_.call.stop.stop_requested())
        schedule_.end(absl::CancelledError("the job was stopped"));
      if (CallOptions::Clock::now() >= options_.call.deadline)
        schedule_.end(
            absl::DeadlineExceededError("the deadline passed before all pieces were done"));
      if (schedule_.answering() > 0 || loading_ > 0) answered_ = Clock::now();
      if (Clock::now() >= end_of_patience())
        schedule_.end(absl::UnavailableError(
            "no server answered for " + std::to_string(options_.patience.count()) + " s" +
            (last_failure_.empty() ? ": the list of servers is empty" : "; " + last_failure_)));
    }
    if (!work_status_.ok()) return work_status_;
    if (!schedule_.status().ok()) return schedule_.status();
    return JobReport{schedule_.fingerprints(), schedule_.duplicates()};
  }

  /// Stops the calls in progress and waits until they end, since they refer to the work.
  ~JobRunner() {
    preparing_.request_stop();
    for (auto& [id, attempt] : attempts_) attempt.stop.request_stop();
    while (under_way_ > 0) {
      for (const Event& event : events_.wait(Clock::time_point::max()))
        under_way_ -= std::holds_alternative<Listed>(event) ? 0 : 1;
    }
  }

 private:
  struct Server {
    std::string target;
    std::optional<Ready> ready;
    std::jthread preparing;
  };
  /// A call in progress.  It keeps the client alive.  Otherwise preparing the server again could
  /// destroy the client in the thread that answers the call (see Client::Done).
  struct Attempt {
    std::stop_source stop;
    Client client;
  };

  /// Deadline of the whole job, in the clock that wait() uses.
  Clock::time_point deadline() const {
    if (options_.call.deadline == CallOptions::Clock::time_point::max())
      return Clock::time_point::max();
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(options_.call.deadline -
                                                                      CallOptions::Clock::now());
  }
  /// When the job ends because no server answers.
  Clock::time_point end_of_patience() const {
    return deadline() == Clock::time_point::max() ? answered_ + options_.patience
                                                  : Clock::time_point::max();
  }
  CallOptions call(const std::stop_source& stop) const {
    return {.deadline = options_.call.deadline, .stop = stop.get_token()};
  }

  void list_servers(const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      events_.post(Listed{options_.servers()});
      stopped.wait_for(lock, stop, kListInterval, [] { return false; });
    }
  }

  // Channel: decisions of the schedule.

  void prepare(ServerId id, const std::string& target) override {
    ++under_way_;
    Server& server = servers_[id];
    server.target = target;
    server.ready.reset();
    // Uploading a scene may take long, so each server has its own thread for it.
    server.preparing = std::jthread([this, id, target] {
      events_.post(PreparedEvent{id, make_ready(target, call(preparing_))});
    });
  }

  absl::StatusOr<Ready> make_ready(const std::string& target, const CallOptions& call) const {
    LUCERNA_ASSIGN_OR_RETURN(
        auto client,
        Client::connect({.target = target, .retry = false, .security = options_.security}));
    LUCERNA_ASSIGN_OR_RETURN(auto info, client.get_server_info({}, call.at_most(kShortCallTime)));
    ++loading_;
    const auto loaded = options_.load(client, call);
    --loading_;
    LUCERNA_RETURN_IF_ERROR(loaded.status());
    v1::GetSceneRequest request;
    request.set_scene_id(loaded->scene_id());
    LUCERNA_ASSIGN_OR_RETURN(auto scene, client.get_scene(request, call.at_most(kShortCallTime)));
    return Ready{std::move(client), std::move(info), std::move(*scene.mutable_summary()),
                 loaded->lease_id()};
  }

  void renew(ServerId id) override {
    ++under_way_;
    const Ready& ready = *servers_[id].ready;
    v1::RenewLeaseRequest request;
    request.set_scene_id(ready.scene.scene_id());
    request.set_lease_id(ready.lease_id);
    request.set_lease_s(static_cast<double>(kJobLease.count()));
    renewals_.insert_or_assign(id, ready.client);
    ready.client.renew_lease(request, call(preparing_).at_most(kShortCallTime),
                             [this, id](const auto& answer) {
                               events_.post(Renewed{id, answer.status()});
                             });
  }

  void start(AttemptId attempt, ServerId id, std::size_t piece) override {
    ++under_way_;
    const Ready& ready = *servers_[id].ready;
    const Attempt& begun = attempts_.emplace(attempt, Attempt{{}, ready.client}).first->second;
    work_.start(piece, begun.client, ready.scene.scene_id(), call(begun.stop),
                [this, attempt](absl::StatusOr<DistributedWork::Result> answer) {
                  events_.post(Finished{attempt, std::move(answer)});
                });
  }

  void cancel(AttemptId attempt) override { attempts_.at(attempt).stop.request_stop(); }

  void report(const std::string& event) override {
    if (options_.on_event) options_.on_event(event);
  }

  // Events from other threads.

  void take(Listed& event) { schedule_.list(event.targets, Clock::now()); }

  void take(PreparedEvent& event) {
    --under_way_;
    absl::StatusOr<JobSchedule::Prepared> answer;
    if (event.answer.ok()) {
      const Ready& ready = *event.answer;
      answer = JobSchedule::Prepared{ready.info.fingerprint().digest(), ready.scene.scene_id()};
      if (!begun_work_) begin_work(ready);
      servers_[event.server].ready.emplace(*std::move(event.answer));
    } else {
      answer = event.answer.status();
      last_failure_ =
          servers_[event.server].target + ": " + std::string(event.answer.status().message());
    }
    schedule_.prepared(event.server, answer, Clock::now());
    progress();
  }

  void begin_work(const Ready& ready) {
    begun_work_ = true;
    work_status_ = work_.begin(ready.scene, ready.info);
    if (work_status_.ok()) schedule_.set_pieces(work_.size());
  }

  void take(Renewed& event) {
    --under_way_;
    renewals_.erase(event.server);
    schedule_.renewed(event.server, event.answer, Clock::now());
  }

  void take(Finished& event) {
    --under_way_;
    const std::size_t piece = schedule_.pieces().attempt(event.attempt).piece;
    attempts_.erase(event.attempt);
    // The server gets its next piece before this result is processed.
    if (schedule_.finished(event.attempt, event.answer.status(), Clock::now()) && work_status_.ok())
      work_status_ = work_.accept(piece, *std::move(event.answer));
    progress();
  }

  void progress() const {
    if (!options_.on_progress) return;
    const JobPieces& pieces = schedule_.pieces();
    options_.on_progress(
        {pieces.done_count(), pieces.count(), schedule_.answering(), Clock::now() - begun_});
  }

  DistributedWork& work_;
  const JobOptions& options_;
  const Clock::time_point begun_ = Clock::now();
  Clock::time_point answered_ = begun_;   // when a server last answered
  mutable std::atomic<int> loading_ = 0;  // servers that answered and load the scene
  std::string last_failure_;              // of a server that cannot begin, with its name
  Events events_;
  std::stop_source preparing_;
  std::unordered_map<AttemptId, Attempt> attempts_;
  std::unordered_map<ServerId, Client> renewals_;  // keeps the clients of renewals in progress
  std::size_t under_way_ = 0;                      // number of calls without an answer
  bool begun_work_ = false;
  absl::Status work_status_;
  JobSchedule schedule_;
  std::map<ServerId, Server> servers_;  // last member: its threads use the others
};

}  // namespace

absl::StatusOr<JobReport> run_job(DistributedWork& work, const JobOptions& options) {
  return JobRunner(work, options).run();
}

}  // namespace lucerna::client

#include "lucerna/client/job.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <thread>
#include <utility>

#include "client/job_pieces.h"
#include "client/retry.h"

namespace lucerna::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFirstBackoff(100);
// With its jitter fewer than fifty attempts a minute.
constexpr milliseconds kLongestBackoff(3000);
constexpr std::chrono::seconds kAskForServers(2);
// Calls that only ask; who takes longer is not there.
constexpr std::chrono::seconds kPatience(10);
constexpr std::chrono::seconds kRenewAfter(20);
constexpr int kMostFailures = 3;

/// Whether it is the server that failed and not the request.
bool is_gone(const absl::Status& status) {
  // gRPC says UNKNOWN of a stream whose server was killed.
  return absl::IsUnavailable(status) || absl::IsUnknown(status) ||
         absl::IsDeadlineExceeded(status) || absl::IsCancelled(status);
}

CallOptions soon(CallOptions call) {
  call.deadline = std::min<CallOptions::Clock::time_point>(call.deadline,
                                                           CallOptions::Clock::now() + kPatience);
  return call;
}

struct Server {
  explicit Server(std::string t) : target(std::move(t)) {}

  const std::string target;
  std::optional<Client> client;
  std::string scene_id, lease_id;
  std::string fingerprint;
  std::stop_source stop;   // of what makes it ready
  bool listed = true;      // among those that are there
  bool ready = false;      // has the scene
  bool preparing = false;  // a thread is at it
  bool told_failure = false;
  bool excluded = false;
  milliseconds backoff = kFirstBackoff;
  Clock::time_point not_before{};  // no attempt earlier
  Clock::time_point renewed{};
  std::vector<std::jthread> threads;
};

class Job {
 public:
  Job(Work& work, const JobOptions& options)
      : work_(work), options_(options), pieces_(work.size()) {}

  absl::StatusOr<JobReport> run() {
    // Without the lock: the stop may come from within one of our callbacks.
    const std::stop_callback stopped(options_.call.stop, [this] { changed_.notify_all(); });
    std::unique_lock lock(mutex_);
    Clock::time_point listed{};
    while (!over()) {
      if (Clock::now() - listed >= kAskForServers) {
        lock.unlock();
        const auto targets = options_.servers();
        lock.lock();
        listed = Clock::now();
        take_list(targets);
      }
      tell_if_alone();
      if (options_.call.stop.stop_requested()) end(absl::CancelledError("the job was stopped"));
      if (CallOptions::Clock::now() >= options_.call.deadline)
        end(absl::DeadlineExceededError("the deadline passed before all pieces were done"));
      changed_.wait_for(lock, milliseconds(200));
    }
    stop_all();
    lock.unlock();
    servers_.clear();  // joins all threads
    if (!status_.ok()) return status_;
    return report_;
  }

 private:
  bool over() const { return !status_.ok() || pieces_.all_done(); }
  void end(const absl::Status& status) {
    if (over()) return;
    status_ = status;
    stop_all();
  }
  void stop_all() {
    pieces_.stop();
    for (const auto& server : servers_) server->stop.request_stop();
    changed_.notify_all();
  }
  void say(const std::string& text) const {
    if (options_.on_event) options_.on_event(text);
  }
  std::size_t answering() const {
    return static_cast<std::size_t>(std::count_if(
        servers_.begin(), servers_.end(), [](const auto& s) { return s->ready && s->listed; }));
  }
  void progress() const {
    if (options_.on_progress)
      options_.on_progress(
          {pieces_.done_count(), pieces_.count(), answering(), Clock::now() - begun_});
  }

  void take_list(const absl::StatusOr<std::vector<std::string>>& targets) {
    if (!targets.ok()) {
      if (servers_.empty()) end(targets.status());
      return;  // those that were there go on
    }
    const std::set<std::string> named(targets->begin(), targets->end());
    for (const auto& server : servers_) {
      if (server->listed && !named.contains(server->target)) {
        say(server->target + " left");
        server->listed = false;
        pieces_.stop(server.get());
      }
      if (!server->listed && named.contains(server->target)) server->listed = true;
    }
    for (const std::string& target : named) {
      const auto is_it = [&](const auto& s) { return s->target == target; };
      if (std::any_of(servers_.begin(), servers_.end(), is_it)) continue;
      const auto& server = servers_.emplace_back(std::make_unique<Server>(target));
      for (int i = 0; i < std::max(options_.window, 1); ++i)
        server->threads.emplace_back([this, s = server.get()] { serve(*s); });
    }
    changed_.notify_all();
  }

  void tell_if_alone() {
    const bool alone = answering() == 0;
    if (alone && !told_alone_ && Clock::now() - begun_ > std::chrono::seconds(2)) {
      say("no server answers: waiting");
      told_alone_ = true;
    } else if (!alone) {
      told_alone_ = false;
    }
  }

  /// One of a server's threads.
  void serve(Server& server) {
    std::unique_lock lock(mutex_);
    while (!over()) {
      const Clock::time_point now = Clock::now();
      if (!server.listed || server.excluded || server.preparing) {
        changed_.wait_for(lock, milliseconds(500));
      } else if (now < server.not_before) {
        changed_.wait_until(lock, server.not_before);
      } else if (!server.ready) {
        prepare(server, lock);
      } else if (now - server.renewed > kRenewAfter) {
        renew(server, lock);
      } else if (const std::optional<JobPieces::Handle> attempt = pieces_.begin(&server)) {
        try_piece(server, *attempt, lock);
      } else {
        changed_.wait_for(lock, milliseconds(500));
      }
    }
  }

  /// Makes the server ready; the lock is let go meanwhile.
  void prepare(Server& server, std::unique_lock<std::mutex>& lock) {
    server.preparing = true;
    CallOptions call = options_.call;
    call.stop = server.stop.get_token();
    std::string fingerprint;
    v1::LoadSceneResponse loaded;
    lock.unlock();
    const absl::Status status = [&]() -> absl::Status {
      auto client = Client::connect({.target = server.target, .retry = false});
      if (!client.ok()) return client.status();
      server.client.emplace(*std::move(client));
      const auto info = server.client->get_server_info({}, soon(call));
      if (!info.ok()) return info.status();
      fingerprint = info->fingerprint().digest();
      auto answer = options_.load(*server.client, call);
      if (answer.ok()) loaded = *std::move(answer);
      return answer.status();
    }();
    lock.lock();
    server.preparing = false;
    changed_.notify_all();
    if (over()) return;
    if (!status.ok()) return failed(server, status);
    if (!fits(server, fingerprint, loaded.scene_id())) return;
    const bool is_new = server.fingerprint.empty();
    server.fingerprint = fingerprint;
    server.scene_id = loaded.scene_id();
    server.lease_id = loaded.lease_id();
    server.ready = true;
    server.renewed = Clock::now();
    server.backoff = kFirstBackoff;
    if (server.told_failure || (is_new && pieces_.done_count() > 0))
      say(server.target + " answers");
    server.told_failure = false;
    progress();
  }

  void renew(Server& server, std::unique_lock<std::mutex>& lock) {
    server.preparing = true;
    CallOptions call = options_.call;
    call.stop = server.stop.get_token();
    v1::RenewLeaseRequest request;
    request.set_scene_id(server.scene_id);
    request.set_lease_id(server.lease_id);
    request.set_lease_s(static_cast<double>(kJobLease.count()));
    lock.unlock();
    const auto renewed = server.client->renew_lease(request, soon(call));
    lock.lock();
    server.preparing = false;
    changed_.notify_all();
    if (over()) return;
    server.renewed = Clock::now();
    if (renewed.ok()) return;
    if (absl::IsNotFound(renewed.status())) {
      server.ready = false;
    } else {
      failed(server, renewed.status());
    }
  }

  /// Whether the server may take part; if not, what follows from that is done.
  bool fits(Server& server, const std::string& fingerprint, const std::string& scene_id) {
    const auto has = [](const auto& s) { return !s->fingerprint.empty() && !s->excluded; };
    const auto other = std::find_if(servers_.begin(), servers_.end(), has);
    if (other == servers_.end()) return true;
    if (fingerprint != (*other)->fingerprint && !options_.allow_mixed) {
      const std::string what = server.target + " (" + fingerprint + ") and " + (*other)->target +
                               " (" + (*other)->fingerprint +
                               ") have different numeric fingerprints: their results would differ "
                               "in last places";
      if (server.fingerprint.empty()) {
        end(absl::FailedPreconditionError(what));
      } else {
        // Started again as another build: the job is done without it.
        server.excluded = true;
        say(what + "; goes on without " + server.target);
      }
      return false;
    }
    if (scene_id != (*other)->scene_id) {
      end(absl::FailedPreconditionError("the scene of " + server.target + " is " + scene_id +
                                        ", that of " + (*other)->target + " is " +
                                        (*other)->scene_id + ": their files differ"));
      return false;
    }
    return true;
  }

  /// After a call that failed.
  void failed(Server& server, const absl::Status& status) {
    if (const auto delay = retry_delay(status)) {  // it is there, and busy
      server.not_before = Clock::now() + *delay;
      return;
    }
    if (!is_gone(status)) {
      return end(absl::Status(status.code(), server.target + ": " + std::string(status.message())));
    }
    server.ready = false;
    if (!server.told_failure && server.listed) {
      say(server.target + " does not answer: " + std::string(status.message()));
      server.told_failure = true;
    }
    std::uniform_real_distribution<double> jitter(0.7, 1.3);
    server.not_before = Clock::now() + std::chrono::duration_cast<Clock::duration>(server.backoff *
                                                                                   jitter(random_));
    server.backoff = std::min(2 * server.backoff, kLongestBackoff);
    progress();
  }

  /// Does what was begun; the lock is let go meanwhile.
  void try_piece(Server& server, JobPieces::Handle attempt, std::unique_lock<std::mutex>& lock) {
    const std::size_t piece = attempt->piece;
    CallOptions call = options_.call;
    call.stop = attempt->stop.get_token();
    const Client client = *server.client;
    const std::string scene_id = server.scene_id;
    lock.unlock();
    absl::StatusOr<Work::Result> result = work_.run(piece, client, scene_id, call);
    lock.lock();
    if (!over() && !pieces_.done(piece) && result.ok()) {
      accept(server, piece, *std::move(result));
    } else if (!over() && pieces_.done(piece)) {
      report_.duplicates += result.ok() ? 1 : 0;
    } else if (!over() && server.listed) {
      failed(server, piece, result.status());
    }
    pieces_.end(attempt);
    changed_.notify_all();
  }

  void failed(Server& server, std::size_t piece, const absl::Status& status) {
    if (!absl::IsNotFound(status) && !absl::IsInternal(status)) return failed(server, status);
    // It lost the scene, or itself: try anew, and not for ever.
    if (++failures_[piece] >= kMostFailures)
      return end(absl::Status(status.code(), server.target + ": " + std::string(status.message())));
    server.ready = false;
  }

  void accept(const Server& server, std::size_t piece, Work::Result result) {
    pieces_.complete(piece);
    if (std::find(report_.fingerprints.begin(), report_.fingerprints.end(), server.fingerprint) ==
        report_.fingerprints.end())
      report_.fingerprints.push_back(server.fingerprint);
    const absl::Status status = work_.accept(piece, std::move(result));
    progress();
    if (!status.ok() && status_.ok()) status_ = status;
  }

  Work& work_;
  const JobOptions& options_;
  const Clock::time_point begun_ = Clock::now();

  std::mutex mutex_;
  std::condition_variable changed_;
  absl::Status status_;
  JobReport report_;
  JobPieces pieces_;
  std::map<std::size_t, int> failures_;
  std::mt19937 random_{std::random_device{}()};
  bool told_alone_ = false;
  std::vector<std::unique_ptr<Server>> servers_;  // the last: its threads use all of the above
};

}  // namespace

absl::StatusOr<JobReport> run_job(Work& work, const JobOptions& options) {
  return Job(work, options).run();
}

}  // namespace lucerna::client

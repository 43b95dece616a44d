#include "client/library/job_schedule.h"

#include <algorithm>
#include <optional>

#include "client/library/retry.h"
#include "client/library/server_error.h"

namespace lucerna::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kFirstBackoff(100);
// With jitter, this gives fewer than fifty attempts in a minute.
constexpr milliseconds kLongestBackoff(3000);
constexpr seconds kRenewAfter(20);
// Servers may start together with the job, so missing servers are not reported in this time.
constexpr seconds kStartTime(2);
// Longest wait before a server without room for the scene is tried again.
constexpr seconds kBusy(10);
constexpr int kMostFailures = 3;

/// Whether the server failed, not the request.
bool is_gone(const absl::Status& status) {
  // gRPC reports UNKNOWN for a stream whose server was killed.
  return absl::IsUnavailable(status) || absl::IsUnknown(status) ||
         absl::IsDeadlineExceeded(status) || absl::IsCancelled(status);
}

}  // namespace

JobSchedule::JobSchedule(const Options& options, Channel& channel, Time now)
    : options_(options), channel_(channel), begun_(now), random_(options.seed) {}

void JobSchedule::set_pieces(std::size_t count) {
  pieces_ = JobPieces(count);
  has_pieces_ = true;
}

void JobSchedule::set(Server& server, bool Server::*flag, bool value) {
  answering_ -= server.answers() ? 1 : 0;
  server.*flag = value;
  answering_ += server.answers() ? 1 : 0;
}

void JobSchedule::end(const absl::Status& status) {
  if (!over()) status_ = status;
}

void JobSchedule::list(const absl::StatusOr<std::vector<std::string>>& targets, Time now) {
  if (!targets.ok()) {
    if (servers_.empty()) end(targets.status());
    return;  // known servers continue
  }
  const std::set<std::string> named(targets->begin(), targets->end());
  for (ServerId id = 0; id < servers_.size(); ++id) {
    Server& server = servers_[id];
    const bool listed = named.contains(server.target);
    if (listed == server.listed) continue;
    set(server, &Server::listed, listed);
    if (listed) {
      serve(id, now);
    } else {
      channel_.report(server.target + " left");
      for (const AttemptId attempt : pieces_.attempts_of(id)) channel_.cancel(attempt);
    }
  }
  for (const std::string& target : named) {
    if (!by_target_.emplace(target, servers_.size()).second) continue;
    Server& server = servers_.emplace_back();
    server.target = target;
    server.backoff = kFirstBackoff;
    server.came_later = listed_once_;
    serve(servers_.size() - 1, now);
  }
  listed_once_ = true;
}

void JobSchedule::wake(ServerId id, Time when) {
  Server& server = servers_[id];
  due_.erase({server.due, id});
  server.due = when;
  if (when != Time::max()) due_.emplace(when, id);
}

void JobSchedule::serve(ServerId id, Time now) {
  Server& server = servers_[id];
  idle_.erase(id);
  wake(id, Time::max());
  if (over() || !server.listed || server.excluded || server.preparing) return;
  if (now < server.not_before) return wake(id, server.not_before);
  if (!server.ready) {
    server.preparing = true;
    return channel_.prepare(id, server.target);
  }
  if (!server.renewing && now - server.renewed >= kRenewAfter) {
    server.renewing = true;
    channel_.renew(id);
  }
  while (server.in_flight < options_.window) {
    if (start_one(id, now)) continue;
    idle_.insert(id);
    break;
  }
  if (!server.renewing) wake(id, server.renewed + kRenewAfter);
}

bool JobSchedule::start_one(ServerId id, Time now) {
  Server& server = servers_[id];
  std::optional<AttemptId> attempt = pieces_.begin(id, now);
  // A duplicate would slow the server's own pieces.
  if (!attempt && server.in_flight == 0) attempt = pieces_.begin_duplicate(id);
  if (!attempt) return false;
  ++server.in_flight;
  channel_.start(*attempt, id, pieces_.attempt(*attempt).piece);
  return true;
}

void JobSchedule::feed(Time now) {
  for (auto it = idle_.begin(); it != idle_.end();) {
    if (!pieces_.any_pending() && !pieces_.any_to_duplicate()) return;
    serve(*it++, now);  // serve() removes and re-inserts the id
  }
}

void JobSchedule::exclude(Server& server, const std::string& why) {
  server.excluded = true;
  const auto may_help = [](const Server& s) { return s.listed && !s.excluded; };
  if (std::any_of(servers_.begin(), servers_.end(), may_help)) {
    channel_.report(why + "; continuing without " + server.target);
  } else {
    end(absl::FailedPreconditionError(why + "; no other server is left"));
  }
}

bool JobSchedule::fits(Server& server, const Prepared& answer) {
  if (!first_) first_ = {server.target, answer};
  const auto& [target, first] = *first_;
  std::string why;
  if (answer.fingerprint != first.fingerprint && !options_.allow_mixed) {
    why = server.target + " (" + answer.fingerprint + ") and " + target + " (" + first.fingerprint +
          ") have different numeric fingerprints: their results would differ in the last digits";
  } else if (answer.scene_id != first.scene_id) {
    why = "the scene of " + server.target + " is " + answer.scene_id + ", that of " + target +
          " is " + first.scene_id + ": their files differ";
  }
  if (why.empty()) return true;
  if (server.came_later || !server.fingerprint.empty()) {
    // A running job continues without it.
    exclude(server, why);
  } else {
    end(absl::FailedPreconditionError(why));
  }
  return false;
}

void JobSchedule::prepared(ServerId id, const absl::StatusOr<Prepared>& answer, Time now) {
  Server& server = servers_[id];
  server.preparing = false;
  if (over()) return;
  if (!answer.ok()) return failed(id, answer.status(), now);
  if (!fits(server, *answer)) return;
  server.is_news =
      server.failure_reported || (server.fingerprint.empty() && pieces_.done_count() > 0);
  server.fingerprint = answer->fingerprint;
  set(server, &Server::ready, true);
  server.renewed = now;
  server.busy_reported = false;
  serve(id, now);
}

void JobSchedule::renewed(ServerId id, const absl::Status& answer, Time now) {
  Server& server = servers_[id];
  server.renewing = false;
  if (over()) return;
  server.renewed = now;
  if (absl::IsNotFound(answer)) {
    set(server, &Server::ready, false);
  } else if (!answer.ok() && server.ready) {
    return failed(id, answer, now);
  }
  serve(id, now);
}

bool JobSchedule::finished(AttemptId attempt, const absl::Status& answer, Time now) {
  const auto [piece, id] = pieces_.attempt(attempt);
  Server& server = servers_[id];
  --server.in_flight;
  const bool was_done = pieces_.done(piece);
  const bool counts = answer.ok() && !was_done && !over();
  if (counts) {
    pieces_.complete(piece);
    // Only a result resets the backoff.  A server that loads the scene but fails at each piece must
    // not be tried at once each time.
    server.backoff = kFirstBackoff;
    for (const AttemptId other : pieces_.attempts_at(piece))
      if (other != attempt) channel_.cancel(other);
    if (std::find(fingerprints_.begin(), fingerprints_.end(), server.fingerprint) ==
        fingerprints_.end())
      fingerprints_.push_back(server.fingerprint);
  }
  duplicates_ += answer.ok() && was_done ? 1 : 0;
  if (answer.ok() && server.is_news) {
    channel_.report(server.target + " answers");
    server.is_news = server.failure_reported = false;
  }
  pieces_.end(attempt);
  if (over()) return counts;
  if (!answer.ok() && !was_done && server.listed) failed_piece(id, piece, answer, now);
  serve(id, now);
  if (!answer.ok()) feed(now);
  return counts;
}

void JobSchedule::failed_piece(ServerId id, std::size_t piece, const absl::Status& status,
                               Time now) {
  Server& server = servers_[id];
  if (!absl::IsNotFound(status) && !absl::IsInternal(status)) {
    // When a server dies, all of its calls fail; only the first failure counts.
    if (server.ready || !is_gone(status)) failed(id, status, now);
    return;
  }
  // The server lost the scene or failed.  Try again, here or elsewhere, but not forever.
  Failures& failures = failures_[piece];
  ++failures.count;
  failures.servers.insert(id);
  const auto may_help = [](const Server& s) { return s.listed && !s.excluded; };
  const auto others = std::count_if(servers_.begin(), servers_.end(), may_help);
  if (failures.count >= kMostFailures && static_cast<std::ptrdiff_t>(failures.servers.size()) >=
                                             std::min<std::ptrdiff_t>(kMostFailures, others))
    return end(from_server(server.target, status));
  report_failure(server, " failed: " + std::string(status.message()));
  set(server, &Server::ready, false);
  back_off(server, now);
}

void JobSchedule::failed(ServerId id, const absl::Status& status, Time now) {
  Server& server = servers_[id];
  if (const auto delay = retry_delay(status)) {  // the server is present but busy
    // Leases of other clients can make this delay long, but they may end earlier.
    server.not_before =
        now + (server.ready ? Time::duration(*delay) : std::min<Time::duration>(*delay, kBusy));
    if (!server.ready && !server.busy_reported) {
      channel_.report(server.target +
                      " cannot take the scene now: " + std::string(status.message()));
      server.busy_reported = true;
    }
    return serve(id, now);
  }
  if (!is_gone(status)) return end(from_server(server.target, status));
  set(server, &Server::ready, false);
  // A server that never answered may be about to start.
  if (!server.fingerprint.empty() || now - begun_ > kStartTime)
    report_failure(server, " does not answer: " + std::string(status.message()));
  back_off(server, now);
  serve(id, now);
}

void JobSchedule::report_failure(Server& server, const std::string& what) {
  if (server.failure_reported || !server.listed) return;
  channel_.report(server.target + what);
  server.failure_reported = true;
}

void JobSchedule::back_off(Server& server, Time now) {
  std::uniform_real_distribution<double> jitter(0.7, 1.3);
  server.not_before =
      now + std::chrono::duration_cast<Time::duration>(server.backoff * jitter(random_));
  server.backoff = std::min(2 * server.backoff, kLongestBackoff);
}

JobSchedule::Time JobSchedule::advance(Time now) {
  while (!over() && !due_.empty() && due_.begin()->first <= now) serve(due_.begin()->second, now);
  const bool none = answering_ == 0;
  if (!none) reported_no_server_ = false;
  if (none && !reported_no_server_ && now - begun_ > kStartTime) {
    const auto is_busy = [](const Server& s) { return s.busy_reported && s.listed; };
    if (std::none_of(servers_.begin(), servers_.end(), is_busy))
      channel_.report("no server answers: waiting");
    reported_no_server_ = true;
  }
  Time next = due_.empty() ? Time::max() : due_.begin()->first;
  if (none && !reported_no_server_) next = std::min(next, begun_ + kStartTime + milliseconds(1));
  return next;
}

}  // namespace lucerna::client

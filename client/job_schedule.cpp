#include "client/job_schedule.h"

#include <algorithm>
#include <optional>

#include "client/retry.h"
#include "client/server_error.h"

namespace lucerna::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kFirstBackoff(100);
// With its jitter fewer than fifty attempts a minute.
constexpr milliseconds kLongestBackoff(3000);
constexpr seconds kRenewAfter(20);
// With servers that start when the job does.
constexpr seconds kPatience(2);
constexpr int kMostFailures = 3;

/// Whether it is the server that failed and not the request.
bool is_gone(const absl::Status& status) {
  // gRPC says UNKNOWN of a stream whose server was killed.
  return absl::IsUnavailable(status) || absl::IsUnknown(status) ||
         absl::IsDeadlineExceeded(status) || absl::IsCancelled(status);
}

}  // namespace

JobSchedule::JobSchedule(std::size_t pieces, const Options& options, Channel& channel, Time now)
    : options_(options), channel_(channel), begun_(now), pieces_(pieces), random_(options.seed) {}

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
    return;  // those that were there go on
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
      channel_.say(server.target + " left");
      for (const AttemptId attempt : pieces_.attempts_of(id)) channel_.cancel(attempt);
    }
  }
  for (const std::string& target : named) {
    if (!by_target_.emplace(target, servers_.size()).second) continue;
    Server& server = servers_.emplace_back();
    server.target = target;
    server.backoff = kFirstBackoff;
    serve(servers_.size() - 1, now);
  }
}

void JobSchedule::wake(ServerId id, Time when) {
  Server& server = servers_[id];
  due_.erase({server.due, id});
  server.due = when;
  if (when != Time::max()) due_.emplace(when, id);
}

void JobSchedule::serve(ServerId id, Time now) {
  Server& server = servers_[id];
  hungry_.erase(id);
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
    hungry_.insert(id);
    break;
  }
  if (!server.renewing) wake(id, server.renewed + kRenewAfter);
}

bool JobSchedule::start_one(ServerId id, Time now) {
  Server& server = servers_[id];
  std::optional<AttemptId> attempt = pieces_.begin(id, now);
  // Beside a piece of its own a duplicate would only slow that.
  if (!attempt && server.in_flight == 0) attempt = pieces_.begin_duplicate(id);
  if (!attempt) return false;
  ++server.in_flight;
  channel_.start(*attempt, id, pieces_.attempt(*attempt).piece);
  return true;
}

void JobSchedule::feed(Time now) {
  for (auto it = hungry_.begin(); it != hungry_.end();) {
    if (!pieces_.any_pending() && !pieces_.any_to_duplicate()) return;
    serve(*it++, now);  // takes itself out, or puts itself back
  }
}

bool JobSchedule::fits(Server& server, const Prepared& answer) {
  const auto has = [](const Server& s) { return !s.fingerprint.empty() && !s.excluded; };
  const auto other = std::find_if(servers_.begin(), servers_.end(), has);
  if (other == servers_.end()) return true;
  if (answer.fingerprint != other->fingerprint && !options_.allow_mixed) {
    const std::string what = server.target + " (" + answer.fingerprint + ") and " + other->target +
                             " (" + other->fingerprint +
                             ") have different numeric fingerprints: their results would differ "
                             "in last places";
    if (server.fingerprint.empty()) {
      end(absl::FailedPreconditionError(what));
    } else {
      // Started again as another build: the job is done without it.
      server.excluded = true;
      channel_.say(what + "; goes on without " + server.target);
    }
    return false;
  }
  if (answer.scene_id != other->scene_id) {
    end(absl::FailedPreconditionError("the scene of " + server.target + " is " + answer.scene_id +
                                      ", that of " + other->target + " is " + other->scene_id +
                                      ": their files differ"));
    return false;
  }
  return true;
}

void JobSchedule::prepared(ServerId id, const absl::StatusOr<Prepared>& answer, Time now) {
  Server& server = servers_[id];
  server.preparing = false;
  if (over()) return;
  if (!answer.ok()) return failed(id, answer.status(), now);
  if (!fits(server, *answer)) return;
  const bool is_new = server.fingerprint.empty();
  server.fingerprint = answer->fingerprint;
  server.scene_id = answer->scene_id;
  set(server, &Server::ready, true);
  server.renewed = now;
  if (server.told_failure || (is_new && pieces_.done_count() > 0))
    channel_.say(server.target + " answers");
  server.told_failure = false;
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
    // Not before: a server that takes the scene and fails at each piece is no better than a dead
    // one.
    server.backoff = kFirstBackoff;
    for (const AttemptId other : pieces_.attempts_at(piece))
      if (other != attempt) channel_.cancel(other);
    if (std::find(fingerprints_.begin(), fingerprints_.end(), server.fingerprint) ==
        fingerprints_.end())
      fingerprints_.push_back(server.fingerprint);
  }
  duplicates_ += answer.ok() && was_done ? 1 : 0;
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
    // Of what was under way at a server that died, the first says all.
    if (server.ready || !is_gone(status)) failed(id, status, now);
    return;
  }
  // It lost the scene, or itself: try anew, and not for ever.
  if (++failures_[piece] >= kMostFailures) return end(from_server(server.target, status));
  set(server, &Server::ready, false);
}

void JobSchedule::failed(ServerId id, const absl::Status& status, Time now) {
  Server& server = servers_[id];
  if (const auto delay = retry_delay(status)) {  // it is there, and busy
    server.not_before = now + *delay;
    return serve(id, now);
  }
  if (!is_gone(status)) return end(from_server(server.target, status));
  set(server, &Server::ready, false);
  // One that was never there may be about to start.
  const bool worth_telling = !server.fingerprint.empty() || now - begun_ > kPatience;
  if (worth_telling && !server.told_failure && server.listed) {
    channel_.say(server.target + " does not answer: " + std::string(status.message()));
    server.told_failure = true;
  }
  std::uniform_real_distribution<double> jitter(0.7, 1.3);
  server.not_before =
      now + std::chrono::duration_cast<Time::duration>(server.backoff * jitter(random_));
  server.backoff = std::min(2 * server.backoff, kLongestBackoff);
  serve(id, now);
}

JobSchedule::Time JobSchedule::advance(Time now) {
  while (!over() && !due_.empty() && due_.begin()->first <= now) serve(due_.begin()->second, now);
  const bool alone = answering_ == 0;
  if (!alone) told_alone_ = false;
  if (alone && !told_alone_ && now - begun_ > kPatience) {
    channel_.say("no server answers: waiting");
    told_alone_ = true;
  }
  Time next = due_.empty() ? Time::max() : due_.begin()->first;
  if (alone && !told_alone_) next = std::min(next, begun_ + kPatience + milliseconds(1));
  return next;
}

}  // namespace lucerna::client

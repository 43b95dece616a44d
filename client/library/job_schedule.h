// Decides which server computes which piece of a job, and when.
//
// The schedule makes no call, starts no thread and reads no clock.  Its methods receive events and
// the time.  It passes its decisions to a Channel.  So the same code runs a job over gRPC (job.cpp)
// and a simulated job on a thousand servers (tests/client/library/job_simulation_test.cpp). Not
// safe for several threads at once.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/library/job_pieces.h"

namespace lucerna::client {

class JobSchedule {
 public:
  using Time = JobPieces::Time;
  using ServerId = JobPieces::ServerId;
  using AttemptId = JobPieces::AttemptId;

  /// Carries out the decisions.  Its methods return at once.  Each answer comes later, through the
  /// method of the schedule that is named here, and never during the call.
  class Channel {
   public:
    virtual ~Channel() = default;
    /// Load the scene on a server; answered by prepared().
    virtual void prepare(ServerId server, const std::string& target) = 0;
    /// Renew the lease of the scene on a server; answered by renewed().
    virtual void renew(ServerId server) = 0;
    /// Compute a piece; answered by finished().
    virtual void start(AttemptId attempt, ServerId server, std::size_t piece) = 0;
    /// Cancel an attempt whose result is not needed; finished() still follows.
    virtual void cancel(AttemptId attempt) = 0;
    /// Report an event to the user.
    virtual void report(const std::string& event) = 0;
  };

  struct Prepared {
    std::string fingerprint;
    std::string scene_id;
  };

  struct Options {
    int window = 2;  ///< pieces in flight on one server, at least 1
    bool allow_mixed = false;
    /// Seed of the jitter.  With jitter, jobs that lost a server at the same time do not all return
    /// at the same time.
    std::uint32_t seed = 0;
  };

  JobSchedule(const Options& options, Channel& channel, Time now);

  /// Sets the number of pieces.  Call it once.  Before that, servers are prepared, and the job is
  /// not over.
  void set_pieces(std::size_t count);

  /// The servers that are present now, each once.  An error ends the job if no server was ever
  /// listed; later errors are ignored.
  void list(const absl::StatusOr<std::vector<std::string>>& targets, Time now);
  void prepared(ServerId server, const absl::StatusOr<Prepared>& answer, Time now);
  void renewed(ServerId server, const absl::Status& answer, Time now);
  /// Returns whether the result is the first of its piece, which is the one that counts.
  bool finished(AttemptId attempt, const absl::Status& answer, Time now);
  /// Performs the actions that are due.  Returns the time of the next call if no event comes
  /// earlier.
  Time advance(Time now);
  /// Ends the job with this status, unless it is over.
  void end(const absl::Status& status);

  bool over() const { return !status_.ok() || (has_pieces_ && pieces_.all_done()); }
  /// The error that ended the job; OK while it runs and after success.
  const absl::Status& status() const { return status_; }
  const JobPieces& pieces() const { return pieces_; }
  std::size_t answering() const { return answering_; }
  /// Numeric fingerprints of the servers whose results counted.
  const std::vector<std::string>& fingerprints() const { return fingerprints_; }
  std::size_t duplicates() const { return duplicates_; }  ///< second results of a piece

 private:
  struct Server {
    std::string target;
    std::string fingerprint;  // empty until it is prepared for the first time
    bool listed = true;       // in the latest list
    bool ready = false;       // holds the scene
    bool preparing = false;
    bool renewing = false;
    bool excluded = false;  // permanently: its build or its scene does not fit
    bool failure_reported = false;
    bool busy_reported = false;
    bool is_news = false;     // its next result is reported as an event
    bool came_later = false;  // was not in the first list
    int in_flight = 0;
    std::chrono::milliseconds backoff{};
    Time not_before{};  // no call before this time
    Time renewed{};
    Time due = Time::max();  // key of its entry in due_

    bool answers() const { return listed && ready; }
  };

  /// Failures that the piece itself may have caused.
  struct Failures {
    int count = 0;
    std::set<ServerId> servers;
  };

  /// Changes a flag that answers() depends on, and keeps `answering_` up to date.
  void set(Server& server, bool Server::*flag, bool value);
  /// Gives the server all actions that are due for it.
  void serve(ServerId id, Time now);
  /// Gives pieces that became available to idle servers.
  void feed(Time now);
  void wake(ServerId id, Time when);
  bool start_one(ServerId id, Time now);
  /// Excludes the server permanently; ends the job if no other server is left.
  void exclude(Server& server, const std::string& why);
  void report_failure(Server& server, const std::string& what);
  void back_off(Server& server, Time now);
  /// Whether the server may take part.  If not, excludes it or ends the job.
  bool fits(Server& server, const Prepared& answer);
  void failed(ServerId id, const absl::Status& status, Time now);
  void failed_piece(ServerId id, std::size_t piece, const absl::Status& status, Time now);

  const Options options_;
  Channel& channel_;
  const Time begun_;
  JobPieces pieces_{0};
  bool has_pieces_ = false;
  absl::Status status_;
  std::vector<Server> servers_;
  std::map<std::string, ServerId> by_target_;
  std::set<ServerId> idle_;                  // servers with free capacity
  std::set<std::pair<Time, ServerId>> due_;  // when to serve a server again
  std::size_t answering_ = 0;
  std::map<std::size_t, Failures> failures_;  // by piece
  std::vector<std::string> fingerprints_;
  std::size_t duplicates_ = 0;
  bool reported_no_server_ = false;
  bool listed_once_ = false;
  std::optional<std::pair<std::string, Prepared>>
      first_;  // the first prepared server, which all others must match
  std::minstd_rand random_;
};

}  // namespace lucerna::client

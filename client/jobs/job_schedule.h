// Decides which server does which piece of a job, and when it is asked.
//
// It makes no call, starts no thread and reads no clock: it is told what happened and what time it
// is, and says through a Channel what is to be done.  So the same code runs a job over gRPC
// (job.cpp) and a simulated one of a thousand servers (tests/client/jobs/job_simulation_test.cpp).
// Not safe for several threads at once.
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
#include "client/jobs/job_pieces.h"

namespace lucerna::client {

class JobSchedule {
 public:
  using Time = JobPieces::Time;
  using ServerId = JobPieces::ServerId;
  using AttemptId = JobPieces::AttemptId;

  /// Does what the schedule decides.  Its methods return at once; what they begin is answered later
  /// through the method of the schedule that is named, and never from within.
  class Channel {
   public:
    virtual ~Channel() = default;
    /// Bring the scene to a server: prepared().
    virtual void prepare(ServerId server, const std::string& target) = 0;
    /// Renew the scene's lease there: renewed().
    virtual void renew(ServerId server) = 0;
    /// Have a piece done: finished().
    virtual void start(AttemptId attempt, ServerId server, std::size_t piece) = 0;
    /// An attempt is of no more use; finished() still follows.
    virtual void cancel(AttemptId attempt) = 0;
    /// Tell a person.
    virtual void say(const std::string& event) = 0;
  };

  struct Prepared {
    std::string fingerprint;
    std::string scene_id;
  };

  struct Options {
    int window = 2;  ///< pieces in flight at one server, at least 1
    bool allow_mixed = false;
    /// Of the jitter: jobs that lose a server at once must not come back at once.
    std::uint32_t seed = 0;
  };

  JobSchedule(const Options& options, Channel& channel, Time now);

  /// How many pieces there are; called once.  Until then servers are made ready, and the job is not
  /// over.
  void set_pieces(std::size_t count);

  /// Who is there now, each once.  An error where that is not known counts only as long as no
  /// server ever was: then it ends the job.
  void list(const absl::StatusOr<std::vector<std::string>>& targets, Time now);
  void prepared(ServerId server, const absl::StatusOr<Prepared>& answer, Time now);
  void renewed(ServerId server, const absl::Status& answer, Time now);
  /// Whether the result is the first of its piece, and so the one that counts.
  bool finished(AttemptId attempt, const absl::Status& answer, Time now);
  /// Does what is due, and says when to come again if nothing happens before.
  Time advance(Time now);
  /// The job ends with this, unless it is over.
  void end(const absl::Status& status);

  bool over() const { return !status_.ok() || (has_pieces_ && pieces_.all_done()); }
  /// What ended the job; OK while it runs and when all is done.
  const absl::Status& status() const { return status_; }
  const JobPieces& pieces() const { return pieces_; }
  std::size_t answering() const { return answering_; }
  /// Of the servers whose results counted.
  const std::vector<std::string>& fingerprints() const { return fingerprints_; }
  std::size_t duplicates() const { return duplicates_; }  ///< results that came second

 private:
  struct Server {
    std::string target;
    std::string fingerprint;  // empty before it was first prepared
    bool listed = true;       // among those that are there
    bool ready = false;       // has the scene
    bool preparing = false;
    bool renewing = false;
    bool excluded = false;  // for good: another build than it was
    bool told_failure = false;
    bool told_busy = false;
    bool is_news = false;     // that it answers
    bool came_later = false;  // than the first list
    int in_flight = 0;
    std::chrono::milliseconds backoff{};
    Time not_before{};  // no attempt earlier
    Time renewed{};
    Time due = Time::max();  // of its entry in due_

    bool answers() const { return listed && ready; }
  };

  /// At a piece, that may be the piece's own fault.
  struct Failures {
    int count = 0;
    std::set<ServerId> servers;
  };

  /// Changes what answers() depends on.
  void set(Server& server, bool Server::*flag, bool value);
  /// Gives the server whatever it can do now.
  void serve(ServerId id, Time now);
  /// Gives what has become free to servers that have nothing to do.
  void feed(Time now);
  void wake(ServerId id, Time when);
  bool start_one(ServerId id, Time now);
  /// Takes the server's part from it for good; ends the job where no other is left.
  void exclude(Server& server, const std::string& why);
  void tell_failure(Server& server, const std::string& what);
  void back_off(Server& server, Time now);
  /// Whether the server may take part; if not, what follows from that is done.
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
  std::set<ServerId> hungry_;                // that could do more than there is
  std::set<std::pair<Time, ServerId>> due_;  // when a server is to be served again
  std::size_t answering_ = 0;
  std::map<std::size_t, Failures> failures_;  // by piece
  std::vector<std::string> fingerprints_;
  std::size_t duplicates_ = 0;
  bool told_alone_ = false;
  bool listed_once_ = false;
  std::optional<std::pair<std::string, Prepared>> first_;  // what all others must fit
  std::minstd_rand random_;
};

}  // namespace lucerna::client

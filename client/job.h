// Work that is shared out among servers, each of which pulls its next piece when it has done one.
//
// A server that is slow gets less; the pieces of one that is gone are done by others; the last ones
// are given to a second server when it has nothing else to do, and the first result counts.  That
// servers give the same bits is what makes this right: so those of other numeric fingerprints are
// not let in.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lucerna/client/client.h"

namespace google::protobuf {
class Message;
}

namespace lucerna::client {

/// Pieces that any server can do, in any order.
class Work {
 public:
  using Result = std::unique_ptr<google::protobuf::Message>;

  virtual ~Work() = default;
  /// Pieces that are still to be done when the job begins, numbered from 0.
  virtual std::size_t size() const = 0;
  /// Does a piece on one server, which holds the scene; called by many threads at once, perhaps
  /// twice for a piece.
  virtual absl::StatusOr<Result> run(std::size_t piece, const Client& client,
                                     const std::string& scene_id,
                                     const CallOptions& options) const = 0;
  /// Takes a piece's result: once a piece, one at a time.  An error ends the job.
  virtual absl::Status accept(std::size_t piece, Result result) = 0;
};

/// What a job asks for; renewed while it runs, and left to run out at its end.
inline constexpr std::chrono::seconds kJobLease(60);

struct JobProgress {
  std::size_t done = 0;
  std::size_t pieces = 0;
  std::size_t servers = 0;  ///< that answer
  std::chrono::duration<double> elapsed{};
};

struct JobOptions {
  /// Who is there, asked again every few seconds: servers may join and leave.
  std::function<absl::StatusOr<std::vector<std::string>>()> servers;
  /// Brings the scene to a server, with a lease of kJobLease or more.  Called before a server's
  /// first piece, and again where it has lost the scene.
  std::function<absl::StatusOr<v1::LoadSceneResponse>(const Client&, const CallOptions&)> load;
  /// Pieces in flight at one server.
  int window = 2;
  /// Let in servers of any numeric fingerprint.
  bool allow_mixed = false;
  /// Of the job as a whole.
  CallOptions call = {};
  /// Called in one thread at a time.
  std::function<void(const JobProgress&)> on_progress = {};
  /// What a person may want to know: servers that come, go and fail.
  std::function<void(const std::string&)> on_event = {};
};

struct JobReport {
  /// Of the servers that did something: one, unless mixing is allowed.
  std::vector<std::string> fingerprints;
  std::size_t duplicates = 0;  ///< results that came second
};

/// Runs until every piece is accepted.  Where no server answers it waits and says so.
///
/// Errors: the list of servers when it cannot be had at all; FAILED_PRECONDITION for servers of
/// different fingerprints or whose scenes differ; what servers say of the request or the scene
/// (INVALID_ARGUMENT, NOT_FOUND, ...); INTERNAL after a piece failed so on three tries; CANCELLED
/// and DEADLINE_EXCEEDED by `call`; those of Work::accept.
absl::StatusOr<JobReport> run_job(Work& work, const JobOptions& options);

}  // namespace lucerna::client

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
#include <utility>
#include <vector>

#include "lucerna/client/client.h"

namespace google::protobuf {
class Message;
}

namespace lucerna::client {

/// Pieces that any server can do, in any order.  All its methods are called by the thread that runs
/// the job, as are the callbacks of JobOptions but for `servers` and `load`.
class Work {
 public:
  using Result = std::unique_ptr<google::protobuf::Message>;
  using Done = std::function<void(absl::StatusOr<Result>)>;

  virtual ~Work() = default;
  /// Called once and before the others, as soon as a first server has the scene: finds out what the
  /// pieces are.  An error ends the job.
  virtual absl::Status begin(const v1::SceneSummary& scene,
                             const v1::GetServerInfoResponse& server) = 0;
  /// Pieces that are still to be done then, numbered from 0.
  virtual std::size_t size() const = 0;
  /// Begins a piece on one server, which holds the scene, and returns at once; perhaps twice for a
  /// piece.  `done` is called once, by any thread, soon where `options.stop` asks for it.
  virtual void start(std::size_t piece, const Client& client, const std::string& scene_id,
                     const CallOptions& options, Done done) = 0;
  /// Takes a piece's result: once a piece.  An error ends the job.
  virtual absl::Status accept(std::size_t piece, Result result) = 0;
};

/// Hands a call's answer to a piece's `done`.
template <class Response>
Client::Done<Response> answer_as(Work::Done done) {
  return [done = std::move(done)](absl::StatusOr<Response> response) {
    if (response.ok()) {
      done(std::make_unique<Response>(*std::move(response)));
    } else {
      done(response.status());
    }
  };
}

/// What a job asks for; renewed while it runs, and left to run out at its end.
inline constexpr std::chrono::seconds kJobLease(60);

struct JobProgress {
  std::size_t done = 0;
  std::size_t pieces = 0;
  std::size_t servers = 0;  ///< that answer
  std::chrono::duration<double> elapsed{};
};

struct JobOptions {
  /// Who is there, asked again every few seconds, in a thread of its own: servers may join and
  /// leave.
  std::function<absl::StatusOr<std::vector<std::string>>()> servers;
  /// Brings the scene to a server, with a lease of kJobLease or more.  Called before a server's
  /// first piece, and again where it has lost the scene; in a thread for each server.
  std::function<absl::StatusOr<v1::LoadSceneResponse>(const Client&, const CallOptions&)> load;
  /// Pieces in flight at one server, at least 1.
  int window = 2;
  /// Let in servers of any numeric fingerprint.
  bool allow_mixed = false;
  /// Of the job as a whole.
  CallOptions call = {};
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
/// and DEADLINE_EXCEEDED by `call`; those of Work::begin and Work::accept.
absl::StatusOr<JobReport> run_job(Work& work, const JobOptions& options);

}  // namespace lucerna::client

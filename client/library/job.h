// Runs work on several servers.  The work is cut into pieces.  Each server takes its next piece
// when it has finished one.
//
//   class Tiles final : public DistributedWork { ... };  // begin, size, start, accept
//   Tiles tiles;
//   const auto list = server_list("a:50051,b:50051");
//   const auto report = run_job(tiles, {.servers = *list, .load = load_the_scene});
//   if (!report.ok()) std::cerr << report.status().message() << '\n';
//
// A slow server gets fewer pieces.  If a server is lost, other servers get its pieces.  When no
// piece is pending, idle servers compute the last pieces a second time, and the first result
// counts.  This is correct because servers of one numeric fingerprint give the same bits.  Servers
// with another fingerprint are therefore excluded.  render_job.h and irradiance_job.h have complete
// jobs for pictures and for irradiance.
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

/// Work in pieces that any server can do, in any order.  The thread that runs the job calls all
/// methods, and all callbacks of JobOptions except `servers` and `load`.
class DistributedWork {
 public:
  using Result = std::unique_ptr<google::protobuf::Message>;
  using Done = std::function<void(absl::StatusOr<Result>)>;

  virtual ~DistributedWork() = default;
  /// Cuts the work into pieces.  Called once, before the other methods, when the first server has
  /// the scene.  An error ends the job.
  virtual absl::Status begin(const v1::SceneSummary& scene,
                             const v1::GetServerInfoResponse& server) = 0;
  /// Number of pieces that are still to be done.  They are numbered from 0.
  virtual std::size_t size() const = 0;
  /// Begins a piece on one server, which holds the scene, and returns at once.  May be called twice
  /// for a piece.  It must call `done` once, from any thread, and soon after a request of
  /// `options.stop`.
  virtual void start(std::size_t piece, const Client& client, const std::string& scene_id,
                     const CallOptions& options, Done done) = 0;
  /// Takes the result of a piece, once per piece.  An error ends the job.
  virtual absl::Status accept(std::size_t piece, Result result) = 0;
};

/// Converts a piece's `done` to the callback of a call.
template <class Response>
Client::Done<Response> answer_as(DistributedWork::Done done) {
  return [done = std::move(done)](absl::StatusOr<Response> response) {
    if (response.ok()) {
      done(std::make_unique<Response>(*std::move(response)));
    } else {
      done(response.status());
    }
  };
}

/// Lease of the scene on each server.  A job renews the lease while it runs.  After the job the
/// lease expires.
inline constexpr std::chrono::seconds kJobLease(60);
/// The most pieces of one job.
inline constexpr std::uint64_t kMostPieces = std::uint64_t{1} << 24;

struct JobProgress {
  std::size_t done = 0;
  std::size_t pieces = 0;
  std::size_t servers = 0;  ///< servers that answer now
  std::chrono::duration<double> elapsed{};
};

struct JobOptions {
  /// Lists the servers.  Called every few seconds in a separate thread, so servers may join and
  /// leave.
  std::function<absl::StatusOr<std::vector<std::string>>()> servers;
  /// Loads the scene on a server, with a lease of kJobLease or more.  Called before a server's
  /// first piece, and again if the server lost the scene.  Each server has its own thread for this
  /// call.
  std::function<absl::StatusOr<v1::LoadSceneResponse>(const Client&, const CallOptions&)> load;
  /// Pieces in flight on one server, at least 1.
  int window = 2;
  /// Accepts servers of any numeric fingerprint.
  bool allow_mixed = false;
  /// Deadline and stop of the whole job.
  CallOptions call = {};
  /// TLS and token for all servers.
  Security security = {};
  /// Without a deadline, the job ends if no server answers for this time.
  std::chrono::seconds patience{300};
  std::function<void(const JobProgress&)> on_progress = {};
  /// Receives messages for people about servers that join, leave and fail.
  std::function<void(const std::string&)> on_event = {};
};

struct JobReport {
  /// Fingerprints of the servers whose results counted.  One, unless `allow_mixed` is set.
  std::vector<std::string> fingerprints;
  std::size_t duplicates = 0;  ///< second results of a piece, which were dropped
};

/// Runs until every piece is accepted.  While no server answers, it waits and reports that as an
/// event, for at most `patience`.
///
/// Errors:
/// - the error of `servers`, if it never succeeded
/// - FAILED_PRECONDITION for servers of different fingerprints or with different scenes
/// - errors of a server about the request or the scene (INVALID_ARGUMENT, NOT_FOUND, ...)
/// - INTERNAL after a piece failed with it three times
/// - CANCELLED and DEADLINE_EXCEEDED from `call`
/// - UNAVAILABLE if no server answered for `patience`
/// - errors of DistributedWork::begin and accept
absl::StatusOr<JobReport> run_job(DistributedWork& work, const JobOptions& options);

}  // namespace lucerna::client

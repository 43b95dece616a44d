// Several servers that hold one scene, asked as if they were one.
//
// For small questions, each of which any server can answer: they go to the servers in turn (gRPC's
// round_robin), and what a server cannot answer because it stops is asked of another.  Pictures and
// large sets of points are jobs (job.h), where a slow server gets less to do.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "lucerna/client/client.h"
#include "lucerna/client/server_list.h"

namespace lucerna::client {

struct QueryServersOptions {
  ServerList servers;
  /// Brings the scene to a server.  Called once for each, and again where one has lost the scene,
  /// by several threads at once.
  std::function<absl::StatusOr<v1::LoadSceneResponse>(const Client&, const CallOptions&)> load;
  /// Ask servers of any numeric fingerprint.
  bool allow_mixed = false;
  /// Of the calls that make the servers ready.
  CallOptions call = {};
  /// Told once of each server that is left out, and why.
  std::function<void(const std::string&)> on_event = {};
};

/// Not thread-safe; client() is.
class QueryServers {
 public:
  /// Brings the scene to every server of the list that answers; the others are left out.
  ///
  /// Errors: those of the list; that of a server where there is none that can be asked, named
  /// before it; FAILED_PRECONDITION for servers of different numeric fingerprints, or where the
  /// scene is another.
  static absl::StatusOr<QueryServers> connect(const QueryServersOptions& options);
  QueryServers(QueryServers&&) noexcept;
  QueryServers& operator=(QueryServers&&) noexcept;
  ~QueryServers();

  /// For questions about scene_id(), and no others: whatever changes a server (leases, uploads)
  /// reaches one of them, and who knows which.
  const Client& client() const;
  const std::string& scene_id() const;
  /// What one of the servers said of the scene.
  const v1::LoadSceneResponse& loaded() const;
  /// More than one only where mixing is allowed.
  std::vector<std::string> fingerprints() const;

  /// What `ask`, a function of the client to a StatusOr, answers.  It is asked again, twice at
  /// most, once the scene has been brought to all servers that answer by then: after NOT_FOUND, as
  /// of a server that was started again and lost the scene; UNAVAILABLE, as where all servers are
  /// others now; UNKNOWN and CANCELLED, as of one that is killed while it answers.
  template <class Ask>
  auto ask(const Ask& ask) -> decltype(ask(std::declval<const Client&>())) {
    auto answer = ask(client());
    for (int again = 0; again < 2 && may_help_to_bring(answer.status()); ++again) {
      if (absl::Status status = bring(); !status.ok()) return status;
      answer = ask(client());
    }
    return answer;
  }

 private:
  struct State;
  explicit QueryServers(std::unique_ptr<State> state);

  static bool may_help_to_bring(const absl::Status& status);
  absl::Status bring();

  std::unique_ptr<State> state_;
};

}  // namespace lucerna::client

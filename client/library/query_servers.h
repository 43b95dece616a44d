// Sends small queries about one scene to several servers.
//
//   auto servers = QueryServers::connect({.servers = *server_list("a:50051,b:50051"),
//                                         .load = load_the_scene});
//   request.set_scene_id(servers->scene_id());
//   const auto answer = servers->query(
//       [&](const Client& client) { return client.sample_li(request); });
//
// Use this for small requests that any server can answer.  Requests go to the servers in turn
// (gRPC's round_robin).  If a server stops before it answers, another server gets the request.  Use
// jobs (job.h) for pictures and large sets of points, since a slow server then gets less work.
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
  /// Loads the scene on a server.  Called once for each server, and again if a server lost the
  /// scene.  Several threads may call it at once.
  std::function<absl::StatusOr<v1::LoadSceneResponse>(const Client&, const CallOptions&)> load;
  /// Accepts servers of any numeric fingerprint.
  bool allow_mixed = false;
  /// TLS and token for all servers.
  Security security = {};
  /// Options of the calls that load the scene.
  CallOptions call = {};
  /// Called once for each server that is excluded, with the reason.
  std::function<void(const std::string&)> on_event = {};
};

/// Not thread-safe, but the client of client() is.
class QueryServers {
 public:
  /// Loads the scene on every server of the list that answers.  The other servers are excluded.
  ///
  /// Errors:
  /// - errors of the list
  /// - the error of a server, with its name, if no server can be used
  /// - FAILED_PRECONDITION for servers of different numeric fingerprints or with different scenes
  static absl::StatusOr<QueryServers> connect(const QueryServersOptions& options);
  QueryServers(QueryServers&&) noexcept;
  QueryServers& operator=(QueryServers&&) noexcept;
  ~QueryServers();

  /// Only for queries about scene_id().  A call that changes a server (leases, uploads) would reach
  /// an arbitrary server.
  const Client& client() const;
  const std::string& scene_id() const;
  /// The answer of one of the servers to LoadScene.
  const v1::LoadSceneResponse& loaded() const;
  /// More than one only with `allow_mixed`.
  std::vector<std::string> fingerprints() const;

  /// Returns question(client()), an absl::StatusOr.  After an error that may mean a lost scene, it
  /// loads the scene on all servers that answer and tries again, at most twice.  These errors are:
  /// - NOT_FOUND, from a server that was restarted
  /// - UNAVAILABLE, if all servers were replaced
  /// - UNKNOWN and CANCELLED, from a server that was killed while it answered
  template <class Question>
  auto query(const Question& question) -> decltype(question(std::declval<const Client&>())) {
    auto answer = question(client());
    for (int again = 0; again < 2 && scene_may_be_lost(answer.status()); ++again) {
      if (absl::Status status = load_everywhere(); !status.ok()) return status;
      answer = question(client());
    }
    return answer;
  }

 private:
  struct State;
  explicit QueryServers(std::unique_ptr<State> state);

  static bool scene_may_be_lost(const absl::Status& status);
  absl::Status load_everywhere();

  std::unique_ptr<State> state_;
};

}  // namespace lucerna::client

// A scene that is used again and again, perhaps on many servers.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "client/jobs/job.h"

namespace lucerna::client {

/// Loads a scene once on each server, and keeps it leased from one use to the next.
///
/// A job that ends while a server still loads would give that up, and never learn whether it was in
/// time.  So loading goes on here, for the next job and for `release`.
class HeldScene {
 public:
  /// As JobOptions has it: with a lease of client::kJobLease.
  using Load = std::function<absl::StatusOr<v1::LoadSceneResponse>(const client::Client&,
                                                                   const client::CallOptions&)>;

  HeldScene() = default;
  /// Stops what is still loading.  Leases run out.
  ~HeldScene();

  /// Renews the lease on a server that holds the scene, and calls `load`, in a thread of its own,
  /// on any other; what `load` refers to must outlive this.  May be called by many threads at once.
  Load through(Load load);

  /// For a single thread: the lease renewed, nothing where the server does not hold the scene.
  absl::StatusOr<std::optional<v1::LoadSceneResponse>> renew(const client::Client& client,
                                                             const client::CallOptions& call);
  /// And what was loaded otherwise.
  void hold(const client::Client& client, const v1::LoadSceneResponse& loaded);

  /// Ends all leases at once, after waiting a little for what still loads.  Where `forget` is set,
  /// servers that did not hold the scene before forget it, unless others have leased it meanwhile.
  /// Who does not answer keeps it until its lease runs out.  Requires that no job is running.
  void release(bool forget, const client::CallOptions& call);

 private:
  struct Holding {
    std::optional<client::Client> client;  // none: nothing is held
    std::string scene_id, lease_id;
    bool brought = false;  // the server did not hold it before
    bool loading = false;
    absl::Status failure;  // of the last try
    std::jthread thread;
  };

  absl::StatusOr<v1::LoadSceneResponse> load_on(const Load& load, const client::Client& client,
                                                const client::CallOptions& call);
  static v1::LoadSceneResponse answer(const Holding& holding);
  static void let_go(const Holding& held, bool forget, const client::CallOptions& call);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<std::string, Holding> holdings_;  // by the server's address
};

}  // namespace lucerna::client

// Keeps a scene loaded for several uses, perhaps on many servers.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "client/library/job.h"

namespace lucerna::client {

/// Loads a scene once on each server, and keeps it leased from one use to the next.
///
/// A job may end while a server still loads the scene.  The job cannot wait for the result.  So
/// loading continues here, for the next job and for release().
class HeldScene {
 public:
  /// The same as JobOptions::load, with a lease of kJobLease.
  using Load = std::function<absl::StatusOr<v1::LoadSceneResponse>(const client::Client&,
                                                                   const client::CallOptions&)>;

  HeldScene() = default;
  /// Stops loading.  Leases expire by themselves.
  ~HeldScene();

  /// Returns a function for JobOptions::load.  On a server that holds the scene, it renews the
  /// lease.  On other servers it calls `load` in a separate thread.  Objects that `load` refers to
  /// must outlive this object.  Many threads may call the result at once.
  Load through(Load load);

  /// Renews the lease.  Returns nothing if the server does not hold the scene.  Not thread-safe.
  absl::StatusOr<std::optional<v1::LoadSceneResponse>> renew(const client::Client& client,
                                                             const client::CallOptions& call);
  /// Takes over a scene that was loaded by other means.
  void hold(const client::Client& client, const v1::LoadSceneResponse& loaded);

  /// Ends all leases, after a short wait for servers that still load.  With `forget`, servers on
  /// which this object loaded the scene unload it, unless others have leased it meanwhile.  A
  /// server that does not answer keeps the scene until its lease expires.  No job may be running.
  void release(bool forget, const client::CallOptions& call);

 private:
  struct Holding {
    std::optional<client::Client> client;  // no value: nothing is held
    std::string scene_id, lease_id;
    bool brought = false;  // the server did not hold the scene before
    bool loading = false;
    absl::Status failure;  // of the last attempt to load
    std::jthread thread;
  };

  absl::StatusOr<v1::LoadSceneResponse> load_on(const Load& load, const client::Client& client,
                                                const client::CallOptions& call);
  static v1::LoadSceneResponse answer(const Holding& holding);
  static void end_lease(const Holding& held, bool forget, const client::CallOptions& call);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<std::string, Holding> holdings_;  // by server address
};

}  // namespace lucerna::client

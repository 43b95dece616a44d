// The scenes in memory, by id and by the path that they were loaded from.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "server/scene.h"

namespace lucerna {

struct StoredScene {
  std::shared_ptr<const Scene> scene;
  std::string path;  ///< that it was first loaded from, relative to the root
};

struct LoadedScene {
  StoredScene stored;
  bool already_loaded = false;
};

/// Thread-safe.
class SceneStore {
 public:
  /// `isa`: Embree's kernels, empty for the best.  Errors: no such directory.
  static absl::StatusOr<std::unique_ptr<SceneStore>> open(const std::string& root,
                                                          const std::string& isa = "");
  ~SceneStore();

  /// Reads and builds the scene file `path`, relative to the root, in the caller's oneTBB arena;
  /// takes as long as that takes.  A file that was loaded before is only hashed again, with all
  /// that it reads; another path of the same content gives the same scene; of several callers that
  /// ask for one path at the same time one builds and the others wait.  Nothing stays of a failed
  /// load.
  ///
  /// Errors: those of load_pbrt and Scene::build; CANCELLED.
  absl::StatusOr<LoadedScene> load(const std::string& path, std::stop_token stop);

  /// Null where no such scene is loaded.
  std::shared_ptr<const Scene> find(const std::string& id) const;
  /// Up to `count` scenes with ids after `after`, in the order of their ids.
  std::vector<StoredScene> list(const std::string& after, std::size_t count) const;
  /// The path of a loaded scene; empty where it is not loaded.
  std::string path(const std::string& id) const;
  /// False where no such scene is loaded.  Who holds the scene keeps it.
  bool release(const std::string& id);

  std::size_t size() const;
  /// How many scenes were built so far.
  std::uint64_t builds() const;

 private:
  struct State;
  explicit SceneStore(std::unique_ptr<State> state);
  absl::StatusOr<LoadedScene> load_alone(const std::string& path, const std::stop_token& stop);

  std::unique_ptr<State> state_;
};

}  // namespace lucerna

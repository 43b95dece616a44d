// The loaded scenes, by id and by source, within a memory budget.  A lease keeps a scene loaded.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "server/files/file_listing.h"
#include "server/files/manifest_source.h"
#include "server/scene/scene.h"
#include "server/store/scene_store_options.h"

namespace lucerna {

class AssetReader;

/// Payload of a RESOURCE_EXHAUSTED after which a retry may succeed: the delay in milliseconds,
/// decimal.
inline constexpr char kRetryAfterPayload[] = "lucerna.retry_after_ms";

/// The files of a scene: a path relative to the root, or uploaded files.
using SceneSource = std::variant<std::string, Manifest>;
/// The name of the scene file.
inline const std::string& main_file(const SceneSource& source) {
  const auto* manifest = std::get_if<Manifest>(&source);
  return manifest != nullptr ? manifest->main : std::get<std::string>(source);
}

struct StoredScene {
  std::shared_ptr<const Scene> scene;
  /// Its name: the path that it was first loaded from, relative to the root, or the main file of
  /// the first manifest.
  std::string path;
  bool uploaded = false;  ///< first loaded from a manifest
  double leased_s = 0;    ///< time from now until the last lease ends
  SceneSource source{};   ///< that it was first loaded from
  LevelFactors factors{};
};

/// The store keeps a scene until all its leases have ended or were released.
struct Lease {
  std::string id;      ///< empty: none
  double seconds = 0;  ///< its duration
};

/// On whose behalf a scene is loaded or leased.
struct Owner {
  std::string name{};
  /// May renew and end the leases of others.
  bool admin = true;
  /// The most leases, and loaded scenes, of this owner at once; 0: no limit.
  std::uint64_t most_leases = 0, most_scenes = 0;
};

/// A lease, for a list.
struct ListedLease {
  std::string id, scene_id, path, owner;
  double left_s = 0;
};

struct LoadedScene {
  StoredScene stored;  ///< its scene is null if files are missing
  bool already_loaded = false;
  Lease lease;
  /// Files that the scene names and the asset store does not have.
  std::vector<MissingAsset> missing;
};

struct LoadOptions {
  double lease_s = 0;  ///< 0: no lease
  std::stop_token stop{};
  /// Only for glTF files.  Each set of factors makes another scene.  Unset: factors of 1; for the
  /// name of an uploaded scene, any factors.
  std::optional<LevelFactors> factors{};
  Owner owner{};  ///< of the lease and of the scene
};

/// Thread-safe.
class SceneStore {
 public:
  /// `assets` has the files of manifests and must outlive the store.  Null: `load` does not accept
  /// manifests.  Errors: no such directory.
  static absl::StatusOr<std::unique_ptr<SceneStore>> open(SceneStoreOptions options,
                                                          AssetStore* assets = nullptr);
  ~SceneStore();

  /// Reads and builds a scene in the caller's oneTBB arena.  Returns the missing files of a
  /// manifest if there are any.  Blocks until it is done.  If the file was loaded before, the store
  /// only hashes it and its files again.  Another path with the same content gives the same scene.
  /// If several callers load one scene at the same time, one builds and the others wait.  A failed
  /// load leaves nothing behind.
  ///
  /// If scenes exceed the budget, the least recently used scenes without a lease are unloaded.  The
  /// size of a scene includes parts that queries built in it later; `find` checks the budget.  The
  /// memory of running loads counts too, so a load that does not fit ends before it needs more.
  ///
  /// An absolute path is accepted if it is under the root.  If no file has this name, the most
  /// recently used uploaded scene of this name is loaded.
  ///
  /// Errors: those of load_scene_file and Scene::build; CANCELLED; RESOURCE_EXHAUSTED if leases
  /// leave no room (with kRetryAfterPayload), if the scene by itself exceeds the budget, or if the
  /// owner has too many leases or scenes.
  absl::StatusOr<LoadedScene> load(const SceneSource& source, const LoadOptions& options = {});

  /// Memory that counts against the budget until `revise` has stored the scene, or the last pointer
  /// is gone.
  class LoadMemory;
  std::shared_ptr<LoadMemory> start_counting() const;

  /// Counts the buffers of a call against the budget until the last pointer is gone.  Until then
  /// the scene that the call uses is not unloaded to make room.  Claims that do not fit are refused
  /// as those of loads.
  std::shared_ptr<LoadBudget> count_call(const Scene& scene) const;

  /// Makes the revision of a scene, or of its revision, with these edits (all of them, not only
  /// new ones).  Without edits it is the scene itself.  `memory`: of what was read for the edits.
  /// If edits move surfaces, the scene's files are read again and its geometry is built again,
  /// unless a revision in memory has the same moves.  Errors: those of Scene::revise;
  /// RESOURCE_EXHAUSTED as for load; FAILED_PRECONDITION if the files have changed.
  absl::StatusOr<LoadedScene> revise(const StoredScene& of, LightEdits edits,
                                     const LoadOptions& options = {}, LoadMemory* memory = nullptr);

  /// What a scene file holds, without building it.
  struct Read {
    std::optional<SceneDescription> description;  ///< nothing if files are missing
    std::vector<MissingAsset> missing;
  };
  /// What is read counts in `memory`.  Errors: those of load_scene_file.
  absl::StatusOr<Read> read(const SceneSource& source, const LoadOptions& options,
                            LoadMemory& memory) const;

  /// Marks the scene as used.  Null if it is not loaded.
  std::shared_ptr<const Scene> find(const std::string& id) const;
  /// Up to `count` scenes with ids after `after`, in the order of their ids.
  std::vector<StoredScene> list(const std::string& after, std::size_t count) const;
  /// One scene; nothing if it is not loaded.
  std::optional<StoredScene> stored(const std::string& id) const;

  /// Makes a lease, or extends the lease `lease`, from now on.  It lasts at most max_lease_s.
  /// NOT_FOUND if the scene is not loaded or does not have this lease (any more), or if another
  /// owner made it and `owner` is no admin.  RESOURCE_EXHAUSTED if the owner has too many.
  absl::StatusOr<Lease> lease(const std::string& id, const std::string& lease, double seconds,
                              const Owner& owner = {});
  /// Ends `lease` (empty: none), and unloads the scene unless another lease keeps it.  True if it
  /// was unloaded.  The scene lives on while anyone has its shared pointer.  NOT_FOUND as above;
  /// FAILED_PRECONDITION if `lease` is empty and the scene has leases.
  absl::StatusOr<bool> release(const std::string& id, const std::string& lease = "",
                               const Owner& owner = {});
  /// Ends all leases of the scene, and unloads it.  NOT_FOUND if it is not loaded.
  absl::Status break_leases(const std::string& id);
  /// Up to `count` leases with ids after `after`, in the order of their ids: those of `owner`, or
  /// all of them if it is an admin.
  std::vector<ListedLease> leases(const Owner& owner, const std::string& after,
                                  std::size_t count) const;

  /// The root as an absolute path.
  const std::string& root() const;
  /// The scene files under the root, which `load` may load.  Reads directories: takes
  /// milliseconds to seconds.
  FileListing available() const;

  std::size_t size() const;
  /// The number of paths and manifests that are known to give a loaded scene.
  std::size_t sources() const;
  /// Bytes of all scenes, measured now.
  std::uint64_t bytes() const;
  /// Bytes of scenes as last measured, of those that calls still use after their release, and of
  /// running loads and calls.
  std::uint64_t counted_bytes() const;
  /// The number of leases of all scenes.
  std::size_t leases() const;
  /// The number of scenes built so far.
  std::uint64_t builds() const;

 private:
  struct State;
  explicit SceneStore(std::unique_ptr<State> state);
  /// A path in its one form.  INVALID_ARGUMENT if it leads out of the root.
  absl::StatusOr<SceneSource> resolved(const SceneSource& source) const;
  /// Loads from a source that no other caller loads from now.
  absl::StatusOr<LoadedScene> load_alone(const SceneSource& source, const std::string& key,
                                         const LoadOptions& options);
  absl::StatusOr<AssetReader> open_root(const std::stop_token& stop, LoadMemory& memory) const;
  absl::StatusOr<LoadedScene> load_uploaded(const std::string& name, const LoadOptions& options);
  struct Moved {
    std::shared_ptr<const Scene> loaded;
    std::shared_ptr<const SceneGeometry> geometry;
  };
  /// The scene without edits, and its geometry with these edits: from memory, from editing them, or
  /// from building the scene again.
  absl::StatusOr<Moved> moved(const StoredScene& of, const SurfaceEdits& edits,
                              const std::stop_token& stop);
  absl::StatusOr<LoadedScene> build_once(SceneDescription description, const std::string& key,
                                         const StoredScene& named, const LoadOptions& options,
                                         LoadMemory& memory);

  std::unique_ptr<State> state_;
};

}  // namespace lucerna

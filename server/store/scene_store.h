// The scenes in memory, by id and by what they were loaded from: at most so many bytes of them, and
// those that somebody leased for as long as the lease runs.
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

#include "server/assets/file_listing.h"
#include "server/assets/manifest_source.h"
#include "server/scene/scene.h"
#include "server/store/scene_store_options.h"

namespace lucerna {

/// Payload of a RESOURCE_EXHAUSTED that time may mend: after how many milliseconds, in decimals.
inline constexpr char kRetryAfterPayload[] = "lucerna.retry_after_ms";

struct StoredScene {
  std::shared_ptr<const Scene> scene;
  /// Its name: the path that it was first loaded from, relative to the root, or the main file of
  /// the first manifest.
  std::string path;
  bool uploaded = false;  ///< first loaded from a manifest
  double leased_s = 0;    ///< for how long leases keep it from now
};

/// A claim to a scene, which is kept until all claims have run out or were released.
struct Lease {
  std::string id;      ///< empty: none
  double seconds = 0;  ///< from when it was given
};

struct LoadedScene {
  StoredScene stored;  ///< no scene where files are missing
  bool already_loaded = false;
  Lease lease;
  /// What the scene names and the store of assets does not hold.
  std::vector<MissingAsset> missing;
};

struct LoadOptions {
  double lease_s = 0;  ///< 0: no lease
  std::stop_token stop{};
};

/// Thread-safe.
class SceneStore {
 public:
  /// `assets` holds the files of manifests and must outlive the store; null: no manifest is ever
  /// loaded.  Errors: no such directory.
  static absl::StatusOr<std::unique_ptr<SceneStore>> open(SceneStoreOptions options,
                                                          AssetStore* assets = nullptr);
  ~SceneStore();

  /// Reads and builds the scene file `path`, relative to the root, in the caller's oneTBB arena;
  /// takes as long as that takes.  A file that was loaded before is only hashed again, with all
  /// that it reads; another path of the same content gives the same scene; of several callers that
  /// ask for one scene at the same time one builds and the others wait.  Nothing stays of a failed
  /// load.
  ///
  /// Where scenes exceed the budget, those without a lease go, the longest unused first.  A scene
  /// counts with what was built in it since it was loaded; the next `find` of it lets others go.
  ///
  /// An absolute path is accepted if it is beneath the root.  A name that no file has finds the
  /// uploaded scene of this name that was used last.
  ///
  /// Errors: those of load_pbrt and Scene::build; CANCELLED; RESOURCE_EXHAUSTED where leases leave
  /// no room (with kRetryAfterPayload) and where there will never be any.
  absl::StatusOr<LoadedScene> load(const std::string& path, const LoadOptions& options = {});
  /// The same of uploaded files, or which of them are missing.
  absl::StatusOr<LoadedScene> load(const Manifest& manifest, const LoadOptions& options = {});

  /// Marks the scene as used.  Null where no such scene is loaded.
  std::shared_ptr<const Scene> find(const std::string& id) const;
  /// Up to `count` scenes with ids after `after`, in the order of their ids.
  std::vector<StoredScene> list(const std::string& after, std::size_t count) const;
  /// One of them; nothing where it is not loaded.
  std::optional<StoredScene> stored(const std::string& id) const;

  /// A new lease, or the one called `lease` from now on.  No longer than the store allows.
  /// NOT_FOUND where no such scene is loaded, or it has no such lease (any more).
  absl::StatusOr<Lease> lease(const std::string& id, const std::string& lease, double seconds);
  /// Ends `lease` (empty: none); the scene goes where no other lease holds it.  True where it
  /// went.  Who holds the scene keeps it.  NOT_FOUND as above; FAILED_PRECONDITION where `lease`
  /// is empty and others have leases.
  absl::StatusOr<bool> release(const std::string& id, const std::string& lease = "");

  /// The root as an absolute path.
  const std::string& root() const;
  /// The .pbrt files beneath the root, which `load` may load.  Reads directories: takes
  /// milliseconds to seconds.
  FileListing available() const;

  std::size_t size() const;
  std::uint64_t bytes() const;
  /// How many scenes were built so far.
  std::uint64_t builds() const;

 private:
  struct State;
  using Source = std::variant<std::string, Manifest>;
  explicit SceneStore(std::unique_ptr<State> state);
  absl::StatusOr<LoadedScene> load_once(const Source& source, const std::string& key,
                                        const LoadOptions& options);
  absl::StatusOr<LoadedScene> load_alone(const Source& source, const std::string& key,
                                         const LoadOptions& options);
  absl::StatusOr<LoadedScene> load_manifest(const Manifest& manifest, const std::string& key,
                                            const LoadOptions& options);
  absl::StatusOr<LoadedScene> load_path(const std::string& path, const std::string& key,
                                        const std::optional<StoredScene>& known,
                                        const LoadOptions& options);
  absl::StatusOr<LoadedScene> load_uploaded(const std::string& name, const LoadOptions& options);
  absl::StatusOr<LoadedScene> build_once(SceneDescription description, const std::string& key,
                                         const StoredScene& named, const LoadOptions& options);

  std::unique_ptr<State> state_;
};

}  // namespace lucerna

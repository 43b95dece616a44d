#include "server/store/scene_store.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/assets/asset_reader.h"
#include "server/store/scene_file.h"

namespace lucerna {
namespace {

using TimePoint = std::chrono::steady_clock::time_point;

bool same_files(const std::vector<Asset>& a, const std::vector<Asset>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Asset& x, const Asset& y) {
    return x.name == y.name && x.sha256 == y.sha256;
  });
}

/// Differs from every path, since paths do not contain a zero byte.
std::string key_of(const Manifest& manifest) {
  std::string text = manifest.main + '\0';
  for (const auto& [name, digest] : manifest.assets) text += name + '\0' + digest + '\0';
  return '\0' + sha256(text);
}

/// Makes keys of one source differ for different factors.
std::string with_factors(std::string key, const LoadOptions& options) {
  const LevelFactors f = options.factors.value_or(LevelFactors());
  if (f != LevelFactors()) key += fmt::format("{}{}:{}:{}", '\0', f.lamps, f.suns, f.emission);
  return key;
}

/// Hard to guess: anyone who knows it may end the lease.
std::string new_lease_id() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) id += fmt::format("{:08x}", random());
  return id;
}

/// Admits one caller at a time for each key.
class Turns {
 public:
  class Turn {
   public:
    Turn(Turns& turns, std::string key) : turns_(turns), key_(std::move(key)) {}
    ~Turn() {
      {
        const std::lock_guard lock(turns_.mutex_);
        turns_.taken_.erase(key_);
      }
      turns_.over_.notify_all();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
    std::string key_;
  };

  /// Null if `stop` is requested first.
  std::unique_ptr<Turn> take(const std::string& key, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    if (!over_.wait(lock, stop, [&] { return !taken_.contains(key); })) return nullptr;
    taken_.insert(key);
    return std::make_unique<Turn>(*this, key);
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any over_;
  std::set<std::string> taken_;
};

struct LeaseEntry {
  TimePoint until;
  std::string owner;
};

struct Entry {
  StoredScene stored;
  std::string owner;        // who loaded it first
  std::uint64_t bytes = 0;  // own, when last measured; it may have grown since then
  std::uint64_t used = 0;   // larger: used later
  std::map<std::string, LeaseEntry> leases;  // by id
};

/// A scene without edits, which it and its revisions keep in memory.
struct Shared {
  std::size_t entries = 0;  // that keep it
  std::uint64_t bytes = 0;  // when last measured
};

const Scene* shared_by(const Entry& entry) {
  const std::shared_ptr<const Scene>& loaded = entry.stored.scene->loaded();
  return loaded != nullptr ? loaded.get() : entry.stored.scene.get();
}

absl::Status cancelled() { return absl::CancelledError("cancelled while the scene was loading"); }

namespace fs = std::filesystem;

/// The absolute path without a slash at its end, and without `.` and `..`.
fs::path normal(const fs::path& directory) {
  const fs::path path = fs::absolute(directory).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

/// `path` relative to `root` if it is an absolute path under `root`; else empty.
std::string path_under(const fs::path& root, const std::string& path) {
  if (!path.starts_with('/')) return {};
  const fs::path relative = fs::path(path).lexically_normal().lexically_relative(root);
  if (relative.empty() || relative == "." || *relative.begin() == "..") return {};
  return relative.string();
}

absl::Status not_found(const std::string& path, const std::string& root, bool has_factors) {
  return absl::NotFoundError(fmt::format(
      "file \"{}\" does not exist under the scene root \"{}\", and no uploaded scene "
      "has this name{}; to use a file of another machine, upload it (lucerna load --upload FILE)",
      path, root, has_factors ? " and these light levels" : ""));
}

absl::Status not_loaded() { return absl::NotFoundError("the scene is not loaded"); }

absl::Status over_quota(const std::string& what) {
  absl::Status status = absl::ResourceExhaustedError(what);
  status.SetPayload(kOverQuotaPayload, absl::Cord());
  return status;
}

absl::Status no_such_lease() {
  return absl::NotFoundError("the scene has no such lease, or the lease has ended");
}

}  // namespace

struct SceneStore::State {
  SceneStoreOptions options;
  std::string root;            // absolute
  std::string canonical_root;  // absolute, links resolved
  AssetStore* assets;
  Turns sources, builds_turns;  // by key of source; by id of scene

  mutable std::mutex mutex;
  std::map<std::string, Entry> scenes;           // by id
  std::map<std::string, std::string> by_source;  // ids
  std::uint64_t uses = 0, builds = 0;
  std::map<const Scene*, Shared> shared;
  std::uint64_t held = 0;  // bytes of all entries and of `shared`, each as last measured

  LoadLimits load_limits() const {
    LoadLimits limits;
    if (options.texture_bytes > 0) limits.texture_bytes = options.texture_bytes;
    return limits;
  }

  // Call the functions below with the lock held.

  /// When the last lease of the scene ends; nothing if it has none.  Removes ended leases.
  std::optional<TimePoint> leased_until(Entry& entry) const {
    const TimePoint now = options.now();
    std::erase_if(entry.leases, [&](const auto& lease) { return lease.second.until <= now; });
    std::optional<TimePoint> last;
    for (const auto& [id, lease] : entry.leases) {
      last = std::max(last.value_or(lease.until), lease.until);
    }
    return last;
  }

  StoredScene snapshot(Entry& entry) const {
    StoredScene stored = entry.stored;
    if (const auto until = leased_until(entry)) {
      stored.leased_s = std::chrono::duration<double>(*until - options.now()).count();
    }
    return stored;
  }

  Lease give_lease(Entry& entry, const std::string& id, double seconds, const Owner& owner) const {
    if (!(seconds > 0)) return {};
    const double granted = std::min(seconds, options.max_lease_s);
    const std::string name = id.empty() ? new_lease_id() : id;
    LeaseEntry& lease = entry.leases[name];
    lease.until = options.now() + std::chrono::duration_cast<std::chrono::nanoseconds>(
                                      std::chrono::duration<double>(granted));
    if (id.empty()) lease.owner = owner.name;  // an admin who renews a lease does not take it
    return {name, granted};
  }

  /// RESOURCE_EXHAUSTED if the owner has no lease left.
  absl::Status check_leases(const Owner& owner) {
    if (owner.most_leases == 0) return absl::OkStatus();
    std::uint64_t held_leases = 0;
    for (auto& [id, entry] : scenes) {
      leased_until(entry);  // removes ended leases
      for (const auto& [name, lease] : entry.leases) held_leases += lease.owner == owner.name;
    }
    if (held_leases < owner.most_leases) return absl::OkStatus();
    return over_quota(fmt::format("\"{}\" has {} leases, allowed: {}; release one", owner.name,
                                  held_leases, owner.most_leases));
  }

  /// RESOURCE_EXHAUSTED if the owner may load no further scene.
  absl::Status check_scenes(const Owner& owner) const {
    if (owner.most_scenes == 0) return absl::OkStatus();
    std::uint64_t held_scenes = 0;
    for (const auto& [id, entry] : scenes) held_scenes += entry.owner == owner.name;
    if (held_scenes < owner.most_scenes) return absl::OkStatus();
    return over_quota(fmt::format("\"{}\" has loaded {} scenes, allowed: {}; release one",
                                  owner.name, held_scenes, owner.most_scenes));
  }

  /// Whether the scene has this lease for the owner.  Call leased_until() before.
  static bool has_lease(const Entry& entry, const std::string& lease, const Owner& owner) {
    const auto found = entry.leases.find(lease);
    return found != entry.leases.end() && (owner.admin || found->second.owner == owner.name);
  }

  void remove(std::map<std::string, Entry>::iterator entry,
              std::vector<std::shared_ptr<const Scene>>& gone) {
    std::erase_if(by_source, [&](const auto& s) { return s.second == entry->first; });
    held -= entry->second.bytes;
    const auto of = shared.find(shared_by(entry->second));
    if (--of->second.entries == 0) {
      held -= of->second.bytes;
      shared.erase(of);
    }
    gone.push_back(std::move(entry->second.stored.scene));
    scenes.erase(entry);
  }

  /// Measures a scene again, since queries may have built parts in it.
  void measure(Entry& entry) {
    const auto set = [this](std::uint64_t& bytes, std::uint64_t now) {
      held += now - bytes;
      bytes = now;
    };
    const Scene* const of = shared_by(entry);
    set(shared[of].bytes, of->own_bytes());
    if (of != entry.stored.scene.get()) set(entry.bytes, entry.stored.scene->own_bytes());
  }
  Entry& insert(Entry entry) {
    ++shared[shared_by(entry)].entries;
    measure(entry);
    const std::string& id = entry.stored.scene->id();
    return scenes.emplace(id, std::move(entry)).first->second;
  }
  void measure_all() {
    for (auto& [id, entry] : scenes) measure(entry);
  }

  /// Unloads the least recently used scenes without a lease until all have at most `most` bytes.
  /// Never unloads `keep`.
  void shrink(std::uint64_t most, const std::string& keep,
              std::vector<std::shared_ptr<const Scene>>& gone) {
    while (held > most) {
      auto oldest = scenes.end();
      for (auto s = scenes.begin(); s != scenes.end(); ++s) {
        if (s->first == keep || leased_until(s->second)) continue;
        if (oldest == scenes.end() || s->second.used < oldest->second.used) oldest = s;
      }
      if (oldest == scenes.end()) return;
      remove(oldest, gone);
    }
  }

  /// Unloads scenes until there is room for `more` bytes.  Unloads none if leases leave too little.
  absl::Status evict_for(std::uint64_t more, std::vector<std::shared_ptr<const Scene>>& gone) {
    const std::uint64_t budget = options.memory_budget_bytes;
    if (budget == 0) return absl::OkStatus();
    if (more > budget)
      return absl::ResourceExhaustedError(
          fmt::format("the scene needs {} bytes, allowed: at most {}", more, budget));
    measure_all();
    std::uint64_t leased = 0;
    std::optional<TimePoint> soonest;
    std::set<const Scene*> counted;
    for (auto& [id, entry] : scenes) {
      const std::optional<TimePoint> until = leased_until(entry);
      if (!until) continue;
      leased += entry.bytes;
      const Scene* const of = shared_by(entry);
      if (counted.insert(of).second) leased += shared.at(of).bytes;
      soonest = std::min(soonest.value_or(*until), *until);
    }
    if (leased + more > budget) {
      absl::Status full = absl::ResourceExhaustedError(
          fmt::format("the scene needs {} bytes, but leased scenes use {} of the server's {}", more,
                      leased, budget));
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(*soonest - options.now());
      full.SetPayload(kRetryAfterPayload,
                      absl::Cord(std::to_string(std::max<std::int64_t>(wait.count(), 1))));
      return full;
    }
    shrink(budget - more, "", gone);
    return absl::OkStatus();
  }

  /// The answer to a load from `key` of a scene that is in the store.
  LoadedScene answer(Entry& entry, const std::string& key, const LoadOptions& load,
                     bool already_loaded) {
    by_source[key] = entry.stored.scene->id();
    entry.used = ++uses;
    return {entry.stored, already_loaded, give_lease(entry, "", load.lease_s, load.owner), {}};
  }
};

absl::StatusOr<std::unique_ptr<SceneStore>> SceneStore::open(SceneStoreOptions options,
                                                             AssetStore* assets) {
  LUCERNA_RETURN_IF_ERROR(AssetReader::open(options.root).status());
  auto state = std::make_unique<State>();
  state->options = std::move(options);
  state->assets = assets;
  state->root = normal(state->options.root).string();
  std::error_code error;
  state->canonical_root = fs::canonical(state->options.root, error).string();
  return std::unique_ptr<SceneStore>(new SceneStore(std::move(state)));
}

SceneStore::SceneStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
SceneStore::~SceneStore() = default;

absl::StatusOr<LoadedScene> SceneStore::load(const std::string& path, const LoadOptions& options) {
  std::string relative = path_under(state_->root, path);
  if (relative.empty()) relative = path_under(state_->canonical_root, path);
  if (relative.empty() && path.starts_with('/')) {
    return absl::InvalidArgumentError(
        fmt::format("file name \"{}\" leaves the scene root \"{}\", allowed: paths inside it; to "
                    "use another file, upload it (lucerna load --upload FILE)",
                    path, state_->root));
  }
  const std::string& name = relative.empty() ? path : relative;
  return load_once(name, with_factors(name, options), options);
}

absl::StatusOr<LoadedScene> SceneStore::load(const Manifest& manifest, const LoadOptions& options) {
  return load_once(manifest, with_factors(key_of(manifest), options), options);
}

absl::StatusOr<LoadedScene> SceneStore::load_once(const Source& source, const std::string& key,
                                                  const LoadOptions& options) {
  if (options.lease_s > 0) {
    const std::lock_guard lock(state_->mutex);
    LUCERNA_RETURN_IF_ERROR(state_->check_leases(options.owner));
  }
  // A caller that waited looks again, because the other load may have failed or been cancelled.
  const auto turn = state_->sources.take(key, options.stop);
  if (turn == nullptr) return cancelled();
  return load_alone(source, key, options);
}

absl::StatusOr<LoadedScene> SceneStore::load_alone(const Source& source, const std::string& key,
                                                   const LoadOptions& options) {
  std::optional<StoredScene> known;
  {
    const std::lock_guard lock(state_->mutex);
    if (const auto id = state_->by_source.find(key); id != state_->by_source.end()) {
      Entry& entry = state_->scenes.at(id->second);
      // Files of a manifest cannot have changed, since it names them by digest.
      if (std::holds_alternative<Manifest>(source))
        return state_->answer(entry, key, options, true);
      known = entry.stored;
    }
  }
  if (const auto* manifest = std::get_if<Manifest>(&source))
    return load_manifest(*manifest, key, options);
  return load_path(std::get<std::string>(source), key, known, options);
}

absl::StatusOr<SceneStore::Read> SceneStore::read(const Manifest& manifest,
                                                  const LoadOptions& options) const {
  Read result;
  AssetReader reader(std::make_unique<ManifestSource>(manifest, *state_->assets, result.missing));
  absl::StatusOr<SceneDescription> description =
      load_scene_file(reader, manifest.main, options.stop, state_->load_limits(),
                      options.factors.value_or(LevelFactors()));
  if (absl::IsCancelled(description.status())) return description.status();
  if (!result.missing.empty()) return result;
  LUCERNA_RETURN_IF_ERROR(description.status());
  for (const Asset& asset : description->assets) {
    const std::string& digest = manifest.assets.at(asset.name);
    if (asset.sha256 == digest) continue;
    // The file on the disk was changed.
    state_->assets->drop(digest);
    result.missing.push_back({asset.name, digest});
  }
  if (result.missing.empty()) result.description = *std::move(description);
  return result;
}

absl::StatusOr<SceneStore::Read> SceneStore::read(const std::string& path,
                                                  const LoadOptions& options) const {
  LUCERNA_ASSIGN_OR_RETURN(AssetReader reader, AssetReader::open(state_->options.root));
  LUCERNA_ASSIGN_OR_RETURN(SceneDescription description,
                           load_scene_file(reader, path, options.stop, state_->load_limits(),
                                           options.factors.value_or(LevelFactors())));
  return Read{std::move(description), {}};
}

absl::StatusOr<LoadedScene> SceneStore::load_manifest(const Manifest& manifest,
                                                      const std::string& key,
                                                      const LoadOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(Read found, read(manifest, options));
  if (!found.description) return LoadedScene{.missing = std::move(found.missing)};
  return build_once(*std::move(found.description), key,
                    {.scene = nullptr,
                     .path = manifest.main,
                     .uploaded = true,
                     .source = manifest,
                     .factors = options.factors.value_or(LevelFactors())},
                    options);
}

absl::StatusOr<LoadedScene> SceneStore::load_path(const std::string& path, const std::string& key,
                                                  const std::optional<StoredScene>& known,
                                                  const LoadOptions& options) {
  absl::StatusOr<AssetReader> reader = AssetReader::open(state_->options.root);
  if (!reader.ok()) return absl::InternalError(reader.status().ToString());
  if (known) {
    const absl::StatusOr<std::vector<Asset>> now = reader->rehash(known->scene->assets());
    // If a file is gone, the load below fails with its name and place.
    if (now.ok() && same_files(*now, known->scene->assets())) {
      // If it is not found, another thread unloaded the scene while its files were read.
      const std::lock_guard lock(state_->mutex);
      const auto found = state_->scenes.find(known->scene->id());
      if (found != state_->scenes.end()) return state_->answer(found->second, key, options, true);
    }
  }
  absl::StatusOr<SceneDescription> description = load_scene_file(
      *reader, path, options.stop, state_->load_limits(), options.factors.value_or(LevelFactors()));
  // NOT_FOUND may also come from a file that the scene names.
  if (absl::IsNotFound(description.status()) && absl::IsNotFound(reader->read(path).status()))
    return load_uploaded(path, options);
  LUCERNA_RETURN_IF_ERROR(description.status());
  return build_once(*std::move(description), key,
                    {.scene = nullptr,
                     .path = path,
                     .source = path,
                     .factors = options.factors.value_or(LevelFactors())},
                    options);
}

absl::StatusOr<LoadedScene> SceneStore::load_uploaded(const std::string& name,
                                                      const LoadOptions& options) {
  const std::lock_guard lock(state_->mutex);
  Entry* latest = nullptr;
  for (auto& [id, entry] : state_->scenes) {
    if (!entry.stored.uploaded || entry.stored.path != name) continue;
    if (entry.stored.scene->loaded() != nullptr) continue;  // a revision
    if (options.factors && *options.factors != entry.stored.scene->level_factors()) continue;
    if (latest == nullptr || entry.used > latest->used) latest = &entry;
  }
  if (latest == nullptr) return not_found(name, state_->root, options.factors.has_value());
  latest->used = ++state_->uses;
  return LoadedScene{
      latest->stored, true, state_->give_lease(*latest, "", options.lease_s, options.owner), {}};
}

absl::StatusOr<LoadedScene> SceneStore::build_once(SceneDescription description,
                                                   const std::string& key, const StoredScene& named,
                                                   const LoadOptions& options) {
  const std::string id =
      scene_id(description.assets, description.textures.halved(), description.level_factors);
  const auto turn = state_->builds_turns.take(id, options.stop);
  if (turn == nullptr) return cancelled();
  {
    const std::lock_guard lock(state_->mutex);
    const auto same = state_->scenes.find(id);
    if (same != state_->scenes.end()) return state_->answer(same->second, key, options, true);
    LUCERNA_RETURN_IF_ERROR(state_->check_scenes(options.owner));
  }
  LUCERNA_ASSIGN_OR_RETURN(const std::shared_ptr<const Scene> scene,
                           Scene::build(std::move(description), state_->options.isa, options.stop));
  Entry entry;
  entry.stored = named;
  entry.stored.scene = scene;
  entry.owner = options.owner.name;
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  LUCERNA_RETURN_IF_ERROR(state_->evict_for(scene->own_bytes(), gone));
  ++state_->builds;
  return state_->answer(state_->insert(std::move(entry)), key, options, false);
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneStore::moved(const StoredScene& of,
                                                               const MovedSurfaces& moves,
                                                               const std::stop_token& stop) {
  std::shared_ptr<const Scene> loaded = of.scene->loaded() ? of.scene->loaded() : of.scene;
  if (loaded->moved() == moves) return loaded;
  {
    const std::lock_guard lock(state_->mutex);
    for (const auto& [id, entry] : state_->scenes) {
      const std::shared_ptr<const Scene>& scene = entry.stored.scene;
      const std::shared_ptr<const Scene>& other = scene->loaded() ? scene->loaded() : scene;
      if (other->id() == loaded->id() && other->moved() == moves) return other;
    }
  }
  const LoadOptions options{.stop = stop, .factors = of.factors};
  LUCERNA_ASSIGN_OR_RETURN(
      Read found, std::visit([&](const auto& source) { return read(source, options); }, of.source));
  if (!found.description ||
      scene_id(found.description->assets, found.description->textures.halved(),
               found.description->level_factors) != loaded->id())
    return absl::FailedPreconditionError(
        fmt::format("the files of \"{}\" are not those that were loaded, and an edit that moves a "
                    "surface reads them again; load the scene again",
                    of.path));
  return Scene::build_moved(*std::move(found.description), moves, state_->options.isa, stop);
}

absl::StatusOr<LoadedScene> SceneStore::revise(const StoredScene& of, LightEdits edits,
                                               const LoadOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(std::shared_ptr<const Scene> base,
                           moved(of, of.scene->moved_by(edits), options.stop));
  LUCERNA_ASSIGN_OR_RETURN(const std::shared_ptr<const Scene> scene,
                           Scene::revise(std::move(base), std::move(edits)));
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  const auto same = state_->scenes.find(scene->id());
  const bool is_known = same != state_->scenes.end();
  if (options.lease_s > 0) LUCERNA_RETURN_IF_ERROR(state_->check_leases(options.owner));
  if (!is_known) {
    LUCERNA_RETURN_IF_ERROR(state_->check_scenes(options.owner));
    LUCERNA_RETURN_IF_ERROR(state_->evict_for(scene->own_bytes(), gone));
    Entry entry;
    entry.stored = of;
    entry.stored.scene = scene;
    entry.stored.leased_s = 0;
    entry.owner = options.owner.name;
    state_->insert(std::move(entry));
  }
  Entry& entry = state_->scenes.at(scene->id());
  entry.used = ++state_->uses;
  return LoadedScene{
      entry.stored, is_known, state_->give_lease(entry, "", options.lease_s, options.owner), {}};
}

std::shared_ptr<const Scene> SceneStore::find(const std::string& id) const {
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  if (found == state_->scenes.end()) return nullptr;
  found->second.used = ++state_->uses;
  std::shared_ptr<const Scene> scene = found->second.stored.scene;
  if (const std::uint64_t budget = state_->options.memory_budget_bytes; budget > 0) {
    state_->measure(found->second);
    state_->shrink(budget, id, gone);
  }
  return scene;
}

std::vector<StoredScene> SceneStore::list(const std::string& after, std::size_t count) const {
  const std::lock_guard lock(state_->mutex);
  std::vector<StoredScene> out;
  for (auto s = state_->scenes.upper_bound(after); s != state_->scenes.end(); ++s) {
    if (out.size() == count) break;
    out.push_back(state_->snapshot(s->second));
  }
  return out;
}

std::optional<StoredScene> SceneStore::stored(const std::string& id) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  if (found == state_->scenes.end()) return std::nullopt;
  return state_->snapshot(found->second);
}

absl::StatusOr<Lease> SceneStore::lease(const std::string& id, const std::string& lease,
                                        double seconds, const Owner& owner) {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  if (found == state_->scenes.end()) return not_loaded();
  state_->leased_until(found->second);  // removes ended leases
  if (lease.empty()) {
    LUCERNA_RETURN_IF_ERROR(state_->check_leases(owner));
  } else if (!State::has_lease(found->second, lease, owner)) {
    return no_such_lease();
  }
  return state_->give_lease(found->second, lease, seconds, owner);
}

absl::StatusOr<bool> SceneStore::release(const std::string& id, const std::string& lease,
                                         const Owner& owner) {
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  if (found == state_->scenes.end()) return not_loaded();
  Entry& entry = found->second;
  state_->leased_until(entry);
  if (!lease.empty()) {
    if (!State::has_lease(entry, lease, owner)) return no_such_lease();
    entry.leases.erase(lease);
  }
  if (const auto until = state_->leased_until(entry)) {
    if (!lease.empty()) return false;
    const std::chrono::duration<double> left = *until - state_->options.now();
    return absl::FailedPreconditionError(
        fmt::format("the scene is leased for another {:.0f} s: release the lease, or wait",
                    std::ceil(left.count())));
  }
  state_->remove(found, gone);
  return true;
}

absl::Status SceneStore::break_leases(const std::string& id) {
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  if (found == state_->scenes.end()) return not_loaded();
  state_->remove(found, gone);
  return absl::OkStatus();
}

std::vector<ListedLease> SceneStore::leases(const Owner& owner, const std::string& after,
                                            std::size_t count) const {
  const std::lock_guard lock(state_->mutex);
  std::vector<ListedLease> out;
  const TimePoint now = state_->options.now();
  for (auto& [scene, entry] : state_->scenes) {
    state_->leased_until(entry);  // removes ended leases
    for (const auto& [id, lease] : entry.leases) {
      if (id <= after || !State::has_lease(entry, id, owner)) continue;
      out.push_back({id, scene, entry.stored.path, lease.owner,
                     std::chrono::duration<double>(lease.until - now).count()});
    }
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  if (out.size() > count) out.resize(count);
  return out;
}

const std::string& SceneStore::root() const { return state_->root; }

FileListing SceneStore::available() const {
  return list_files(state_->options.root, scene_file_extensions());
}

std::size_t SceneStore::size() const {
  const std::lock_guard lock(state_->mutex);
  return state_->scenes.size();
}

std::uint64_t SceneStore::bytes() const {
  const std::lock_guard lock(state_->mutex);
  state_->measure_all();
  return state_->held;
}

std::size_t SceneStore::leases() const {
  const std::lock_guard lock(state_->mutex);
  std::size_t n = 0;
  for (auto& [id, entry] : state_->scenes) {
    state_->leased_until(entry);  // removes ended leases
    n += entry.leases.size();
  }
  return n;
}

std::uint64_t SceneStore::builds() const {
  const std::lock_guard lock(state_->mutex);
  return state_->builds;
}

}  // namespace lucerna

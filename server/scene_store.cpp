#include "server/scene_store.h"

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "server/asset_reader.h"
#include "server/pbrt/load.h"

namespace lucerna {
namespace {

bool same_files(const std::vector<Asset>& a, const std::vector<Asset>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Asset& x, const Asset& y) {
    return x.name == y.name && x.sha256 == y.sha256;
  });
}

}  // namespace

struct SceneStore::State {
  std::string root, isa;
  mutable std::mutex mutex;
  std::condition_variable_any loaded;
  std::map<std::string, StoredScene> scenes;   // by id
  std::map<std::string, std::string> by_path;  // ids
  std::set<std::string> loading;               // paths
  std::uint64_t builds = 0;

  std::optional<StoredScene> find_path(const std::string& path) const {
    const std::lock_guard lock(mutex);
    const auto id = by_path.find(path);
    if (id == by_path.end()) return std::nullopt;
    return scenes.at(id->second);
  }

  /// The scene made of just these files, remembered for `path` too.
  std::optional<StoredScene> find_files(const std::string& path, const std::vector<Asset>& assets) {
    const std::lock_guard lock(mutex);
    for (const auto& [id, stored] : scenes) {
      if (same_files(stored.scene->assets(), assets)) {
        by_path[path] = id;
        return stored;
      }
    }
    return std::nullopt;
  }
};

absl::StatusOr<std::unique_ptr<SceneStore>> SceneStore::open(const std::string& root,
                                                             const std::string& isa) {
  const absl::StatusOr<AssetReader> reader = AssetReader::open(root);
  if (!reader.ok()) return reader.status();
  auto state = std::make_unique<State>();
  state->root = root;
  state->isa = isa;
  return std::unique_ptr<SceneStore>(new SceneStore(std::move(state)));
}

SceneStore::SceneStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
SceneStore::~SceneStore() = default;

absl::StatusOr<LoadedScene> SceneStore::load(const std::string& path, std::stop_token stop) {
  {
    std::unique_lock lock(state_->mutex);
    // Whoever waited looks for itself: the other's load may have failed or have been cancelled.
    if (!state_->loaded.wait(lock, stop, [&] { return !state_->loading.contains(path); })) {
      return absl::CancelledError("cancelled while the scene was loading");
    }
    state_->loading.insert(path);
  }
  struct Done {
    State& state;
    const std::string& path;
    ~Done() {
      {
        const std::lock_guard lock(state.mutex);
        state.loading.erase(path);
      }
      state.loaded.notify_all();
    }
  } done{*state_, path};
  return load_alone(path, stop);
}

absl::StatusOr<LoadedScene> SceneStore::load_alone(const std::string& path,
                                                   const std::stop_token& stop) {
  absl::StatusOr<AssetReader> reader = AssetReader::open(state_->root);
  if (!reader.ok()) return absl::InternalError(reader.status().ToString());
  if (const std::optional<StoredScene> known = state_->find_path(path)) {
    const absl::StatusOr<std::vector<Asset>> now = reader->rehash(known->scene->assets());
    // Where a file is gone, loading says which and where it is asked for.
    if (now.ok() && same_files(*now, known->scene->assets())) {
      // Let go while its files were read: it is loaded again all the same.
      const std::lock_guard lock(state_->mutex);
      if (state_->scenes.contains(known->scene->id())) return LoadedScene{*known, true};
    }
  }
  absl::StatusOr<SceneDescription> description = load_pbrt(*reader, path, stop);
  if (!description.ok()) return description.status();
  if (const auto same = state_->find_files(path, description->assets)) {
    return LoadedScene{*same, true};
  }
  const absl::StatusOr<std::shared_ptr<const Scene>> scene =
      Scene::build(*std::move(description), state_->isa, stop);
  if (!scene.ok()) return scene.status();
  const std::lock_guard lock(state_->mutex);
  ++state_->builds;
  const auto [place, is_new] =
      state_->scenes.try_emplace((*scene)->id(), StoredScene{*scene, path});
  state_->by_path[path] = place->first;
  return LoadedScene{place->second, !is_new};
}

std::shared_ptr<const Scene> SceneStore::find(const std::string& id) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  return found == state_->scenes.end() ? nullptr : found->second.scene;
}

std::vector<StoredScene> SceneStore::list(const std::string& after, std::size_t count) const {
  const std::lock_guard lock(state_->mutex);
  std::vector<StoredScene> out;
  for (auto s = state_->scenes.upper_bound(after); s != state_->scenes.end(); ++s) {
    if (out.size() == count) break;
    out.push_back(s->second);
  }
  return out;
}

std::string SceneStore::path(const std::string& id) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  return found == state_->scenes.end() ? "" : found->second.path;
}

bool SceneStore::release(const std::string& id) {
  std::shared_ptr<const Scene> last;  // destroyed, if so, outside of the lock
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->scenes.find(id);
  if (found == state_->scenes.end()) return false;
  last = found->second.scene;
  state_->scenes.erase(found);
  std::erase_if(state_->by_path, [&](const auto& p) { return p.second == id; });
  return true;
}

std::size_t SceneStore::size() const {
  const std::lock_guard lock(state_->mutex);
  return state_->scenes.size();
}
std::uint64_t SceneStore::builds() const {
  const std::lock_guard lock(state_->mutex);
  return state_->builds;
}

}  // namespace lucerna

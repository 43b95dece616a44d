// Loads of scenes, and revisions.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "lights/maths/stop_poll.h"
#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/files/asset_reader.h"
#include "server/runtime/memory.h"
#include "server/scene/moved_geometry.h"
#include "server/store/scene_file.h"
#include "server/store/store_state.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

bool same_files(const std::vector<Asset>& a, const std::vector<Asset>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Asset& x, const Asset& y) {
    return x.name == y.name && x.sha256 == y.sha256;
  });
}

/// Equal only for one source with the same factors.  Paths do not contain a zero byte.
std::string key_of(const SceneSource& source, const LoadOptions& options) {
  std::string key;
  if (const auto* manifest = std::get_if<Manifest>(&source)) {
    std::string text = manifest->main + '\0';
    for (const auto& [name, digest] : manifest->assets) text += name + '\0' + digest + '\0';
    key = '\0' + sha256(text);
  } else {
    key = std::get<std::string>(source);
  }
  const LevelFactors f = options.factors.value_or(LevelFactors());
  if (f != LevelFactors()) key += fmt::format("{}{}:{}:{}", '\0', f.lamps, f.suns, f.emission);
  return key;
}

AssetReaderOptions reader_options(const LoadLimits& limits, const std::stop_token& stop) {
  AssetReaderOptions options;
  options.max_total_bytes = limits.max_scene_bytes;
  options.stop = stop;
  options.budget = limits.budget;
  return options;
}

absl::Status cancelled() { return absl::CancelledError("cancelled while the scene was loading"); }

/// `work()`, whose loops end after a request of `stop`.
template <typename Work>
auto stoppable(const std::stop_token& stop, const Work& work) -> decltype(work()) {
  const StopScope scope(stop);
  try {
    return work();
  } catch (const Stopped&) {
    return cancelled();
  }
}

/// `path` relative to `root` if it is an absolute path under `root`; else empty.
std::string path_under(const fs::path& root, const std::string& path) {
  if (!path.starts_with('/')) return {};
  const fs::path relative = fs::path(path).lexically_normal().lexically_relative(root);
  if (relative.empty() || relative == "." || *relative.begin() == "..") return {};
  return relative.string();
}

/// The name without `.`, `..` and empty parts, so that a file has one name.  Names that lead out of
/// the root stay as they are: they are refused where they are opened.
std::string normal_name(const std::string& name) {
  std::string normal = fs::path(name).lexically_normal().string();
  while (normal.ends_with('/')) normal.pop_back();
  if (normal.empty() || normal == "." || normal == ".." || normal.starts_with("../")) return name;
  return normal;
}

absl::Status not_found(const std::string& path, const std::string& root, bool has_factors) {
  return absl::NotFoundError(fmt::format(
      "file \"{}\" does not exist under the scene root \"{}\", and no uploaded scene "
      "has this name{}; to use a file of another machine, upload it (lucerna load --upload FILE)",
      path, root, has_factors ? " and these light levels" : ""));
}

}  // namespace

absl::StatusOr<SceneSource> SceneStore::resolved(const SceneSource& source) const {
  const auto* path = std::get_if<std::string>(&source);
  if (path == nullptr) return source;
  std::string relative = path_under(state_->root, *path);
  if (relative.empty()) relative = path_under(state_->canonical_root, *path);
  if (relative.empty() && path->starts_with('/'))
    return absl::InvalidArgumentError(
        fmt::format("file name \"{}\" leaves the scene root \"{}\", allowed: paths inside it; to "
                    "use another file, upload it (lucerna load --upload FILE)",
                    *path, state_->root));
  return relative.empty() ? normal_name(*path) : relative;
}

absl::StatusOr<LoadedScene> SceneStore::load(const SceneSource& given, const LoadOptions& options) {
  LUCERNA_ASSIGN_OR_RETURN(const SceneSource source, resolved(given));
  const std::string key = key_of(source, options);
  if (options.lease_s > 0) {
    const std::lock_guard lock(state_->mutex);
    LUCERNA_RETURN_IF_ERROR(state_->check_leases(options.owner));
  }
  // A caller that waited looks again, because the other load may have failed or been cancelled.
  const auto turn = state_->sources.take(key, options.stop);
  if (turn == nullptr) return cancelled();
  absl::StatusOr<LoadedScene> loaded =
      stoppable(options.stop, [&] { return load_alone(source, key, options); });
  // The allocator would keep what a failed load has freed, beside the budget.
  if (!loaded.ok()) return_free_memory();
  return loaded;
}

absl::StatusOr<LoadedScene> SceneStore::load_alone(const SceneSource& source,
                                                   const std::string& key,
                                                   const LoadOptions& options) {
  LoadMemory memory(*state_);
  const auto* path = std::get_if<std::string>(&source);
  std::optional<StoredScene> known;
  {
    const std::lock_guard lock(state_->mutex);
    if (const auto id = state_->by_source.find(key); id != state_->by_source.end()) {
      Entry& entry = state_->scenes.at(id->second);
      // Files of a manifest cannot have changed, since it names them by digest.
      if (path == nullptr) return state_->answer(entry, key, options, true);
      known = entry.stored;
    }
  }
  if (known) {
    LUCERNA_ASSIGN_OR_RETURN(AssetReader reader, open_root(options.stop, memory));
    const absl::StatusOr<std::vector<Asset>> now = reader.rehash(known->scene->report().assets);
    // If a file is gone, the load below fails with its name and place.
    if (now.ok() && same_files(*now, known->scene->report().assets)) {
      // If it is not found, another thread unloaded the scene while its files were read.
      const std::lock_guard lock(state_->mutex);
      const auto found = state_->scenes.find(known->scene->id());
      if (found != state_->scenes.end()) return state_->answer(found->second, key, options, true);
    }
  }
  absl::StatusOr<Read> found = read(source, options, memory);
  if (path != nullptr && absl::IsNotFound(found.status())) {
    // NOT_FOUND may also come from a file that the scene names.
    LUCERNA_ASSIGN_OR_RETURN(AssetReader reader, open_root(options.stop, memory));
    if (absl::IsNotFound(reader.read(*path).status())) return load_uploaded(*path, options);
  }
  LUCERNA_RETURN_IF_ERROR(found.status());
  if (!found->description) {
    LoadedScene incomplete;
    incomplete.missing = std::move(found->missing);
    return incomplete;
  }
  return build_once(*std::move(found->description), key,
                    {.scene = nullptr,
                     .path = main_file(source),
                     .uploaded = path == nullptr,
                     .source = source,
                     .factors = options.factors.value_or(LevelFactors())},
                    options, memory);
}

std::shared_ptr<SceneStore::LoadMemory> SceneStore::start_counting() const {
  return std::make_shared<LoadMemory>(*state_);
}

std::shared_ptr<LoadBudget> SceneStore::count_call(const Scene& scene) const {
  const auto memory = std::make_shared<LoadMemory>(*state_, scene.id());
  return {memory, &memory->budget()};
}

absl::StatusOr<AssetReader> SceneStore::open_root(const std::stop_token& stop,
                                                  LoadMemory& memory) const {
  absl::StatusOr<AssetReader> reader = AssetReader::open(
      state_->options.root, reader_options(state_->load_limits(memory.budget()), stop));
  if (!reader.ok()) return absl::InternalError(reader.status().ToString());
  return reader;
}

absl::StatusOr<SceneStore::Read> SceneStore::read(const SceneSource& source,
                                                  const LoadOptions& options,
                                                  LoadMemory& memory) const {
  Read result;
  const LoadLimits limits = state_->load_limits(memory.budget());
  const auto* manifest = std::get_if<Manifest>(&source);
  absl::StatusOr<AssetReader> reader =
      manifest == nullptr ? open_root(options.stop, memory)
                          : AssetReader(std::make_unique<ManifestSource>(*manifest, *state_->assets,
                                                                         result.missing),
                                        reader_options(limits, options.stop));
  LUCERNA_RETURN_IF_ERROR(reader.status());
  absl::StatusOr<SceneDescription> description = stoppable(options.stop, [&] {
    return load_scene_file(*reader, main_file(source), options.stop, limits,
                           options.factors.value_or(LevelFactors()));
  });
  if (absl::IsCancelled(description.status())) return description.status();
  if (!result.missing.empty()) return result;
  LUCERNA_RETURN_IF_ERROR(memory.explained(description.status()));
  for (const Asset& asset : description->assets) {
    if (manifest == nullptr) break;
    const std::string& digest = manifest->assets.at(asset.name);
    if (asset.sha256 == digest) continue;
    // The file on the disk was changed.
    state_->assets->drop(digest);
    result.missing.push_back({asset.name, digest});
  }
  if (result.missing.empty()) result.description = *std::move(description);
  return result;
}

absl::StatusOr<LoadedScene> SceneStore::load_uploaded(const std::string& name,
                                                      const LoadOptions& options) {
  const std::lock_guard lock(state_->mutex);
  Entry* latest = nullptr;
  for (auto& [id, entry] : state_->scenes) {
    if (!entry.stored.uploaded || entry.stored.path != name) continue;
    if (entry.stored.scene->loaded() != nullptr) continue;  // a revision
    if (options.factors && *options.factors != entry.stored.scene->report().level_factors) continue;
    if (latest == nullptr || entry.used > latest->used) latest = &entry;
  }
  if (latest == nullptr) return not_found(name, state_->root, options.factors.has_value());
  latest->used = ++state_->uses;
  return LoadedScene{
      latest->stored, true, state_->give_lease(*latest, "", options.lease_s, options.owner), {}};
}

absl::StatusOr<LoadedScene> SceneStore::build_once(SceneDescription description,
                                                   const std::string& key, const StoredScene& named,
                                                   const LoadOptions& options, LoadMemory& memory) {
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
  absl::StatusOr<std::shared_ptr<const Scene>> built =
      Scene::build(std::move(description), state_->options.isa, options.stop, &memory.budget());
  LUCERNA_RETURN_IF_ERROR(memory.explained(built.status()));
  const std::shared_ptr<const Scene> scene = *std::move(built);
  Entry entry;
  entry.stored = named;
  entry.stored.scene = scene;
  entry.owner = options.owner.name;
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  memory.end();
  LUCERNA_RETURN_IF_ERROR(state_->evict_for(scene->own_bytes(), 0, gone));
  ++state_->builds;
  return state_->answer(state_->insert(std::move(entry)), key, options, false);
}

absl::StatusOr<SceneStore::Moved> SceneStore::moved(const StoredScene& of,
                                                    const SurfaceEdits& edits,
                                                    const std::stop_token& stop) {
  std::shared_ptr<const Scene> loaded = of.scene->loaded() ? of.scene->loaded() : of.scene;
  if (loaded->geometry().edits() == edits) return Moved{loaded, loaded->shared_geometry()};
  {
    const std::lock_guard lock(state_->mutex);
    const std::string id = loaded->id();
    for (const auto& [key, entry] : state_->scenes) {
      const std::shared_ptr<const Scene>& scene = entry.stored.scene;
      const std::shared_ptr<const Scene>& other = scene->loaded() ? scene->loaded() : scene;
      if (other->id() != id) continue;
      if (scene->geometry().edits() == edits) return Moved{other, scene->shared_geometry()};
      if (other->geometry().edits().empty()) loaded = other;
    }
  }
  LUCERNA_ASSIGN_OR_RETURN(std::shared_ptr<const SceneGeometry> geometry,
                           moved_geometry(loaded->geometry(), loaded->lights(), edits, stop));
  if (geometry != nullptr) return Moved{std::move(loaded), std::move(geometry)};
  const LoadOptions options{.stop = stop, .factors = of.factors};
  LoadMemory memory(*state_);
  LUCERNA_ASSIGN_OR_RETURN(Read found, read(of.source, options, memory));
  if (!found.description ||
      scene_id(found.description->assets, found.description->textures.halved(),
               found.description->level_factors) != loaded->id())
    return absl::FailedPreconditionError(
        fmt::format("the files of \"{}\" have changed since the scene was loaded, and an edit that "
                    "moves a surface reads them again; load the scene again",
                    of.path));
  MovedSurfaces moves = edits.moved;
  std::erase_if(moves, [&](const auto& m) { return edits.added.contains(m.first); });
  absl::StatusOr<std::shared_ptr<const Scene>> built = Scene::build_moved(
      *std::move(found.description), moves, state_->options.isa, stop, &memory.budget());
  if (!built.ok()) return memory.explained(built.status());
  if (edits.added.empty()) return Moved{*built, (*built)->shared_geometry()};
  LUCERNA_ASSIGN_OR_RETURN(geometry,
                           moved_geometry((*built)->geometry(), (*built)->lights(), edits, stop));
  if (geometry != nullptr) return Moved{*built, std::move(geometry)};
  return absl::InvalidArgumentError(
      "an added surface lies outside of the scene, or its size would change the unit of rays, "
      "allowed: surfaces within the scene; load the scene with the surface in its file");
}

absl::StatusOr<LoadedScene> SceneStore::revise(const StoredScene& of, LightEdits edits,
                                               const LoadOptions& options, LoadMemory* memory) {
  using Revised = absl::StatusOr<std::shared_ptr<const Scene>>;
  LUCERNA_ASSIGN_OR_RETURN(
      const std::shared_ptr<const Scene> scene, stoppable(options.stop, [&]() -> Revised {
        LUCERNA_ASSIGN_OR_RETURN(
            Moved from,
            moved(of, surface_edits(of.scene->without_edits().lights(), edits), options.stop));
        return Scene::revise(std::move(from.loaded), std::move(from.geometry), std::move(edits),
                             options.stop);
      }));
  std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
  const std::lock_guard lock(state_->mutex);
  if (memory != nullptr) memory->end();
  const auto same = state_->scenes.find(scene->id());
  const bool is_known = same != state_->scenes.end();
  if (options.lease_s > 0) LUCERNA_RETURN_IF_ERROR(state_->check_leases(options.owner));
  if (!is_known) {
    LUCERNA_RETURN_IF_ERROR(state_->check_scenes(options.owner));
    // What other scenes in memory have already needs no room.
    std::uint64_t needed = unshared_bytes(*scene);
    for_each_shared(*scene, [&](const void* what, std::uint64_t bytes) {
      if (!state_->shared.contains(what)) needed += bytes;
    });
    LUCERNA_RETURN_IF_ERROR(state_->evict_for(needed, 0, gone));
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

}  // namespace lucerna

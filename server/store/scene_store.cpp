#include "server/store/scene_store.h"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/files/asset_reader.h"
#include "server/store/scene_file.h"
#include "server/store/store_state.h"

namespace lucerna {
namespace {

namespace fs = std::filesystem;

/// The absolute path without a slash at its end, and without `.` and `..`.
fs::path normal(const fs::path& directory) {
  const fs::path path = fs::absolute(directory).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

absl::Status not_loaded() { return absl::NotFoundError("the scene is not loaded"); }

absl::Status no_such_lease() {
  return absl::NotFoundError("the scene has no such lease, or the lease has ended");
}

}  // namespace

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

std::size_t SceneStore::sources() const {
  const std::lock_guard lock(state_->mutex);
  return state_->by_source.size();
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

std::uint64_t SceneStore::counted_bytes() const {
  const std::lock_guard lock(state_->mutex);
  std::uint64_t bytes = state_->held + state_->loading;
  for (const auto& [scene, own] : state_->removed) bytes += scene.expired() ? 0 : own;
  return bytes;
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

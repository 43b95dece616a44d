// The state of a SceneStore: entries, leases, eviction, and the memory of loads.  Used by the files
// of the store.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "proto/common/status_macros.h"
#include "server/runtime/memory.h"
#include "server/store/scene_store.h"

namespace lucerna {

using TimePoint = std::chrono::steady_clock::time_point;

/// Hard to guess: anyone who knows it may end the lease.
inline std::string new_lease_id() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) id += fmt::format("{:08x}", random());
  return id;
}

/// Admits one caller at a time for each key.
class Turns {
 public:
  /// The turn ends with its last copy.  Null if `stop` is requested first.
  std::shared_ptr<void> take(const std::string& key, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    if (!over_.wait(lock, stop, [&] { return !taken_.contains(key); })) return nullptr;
    taken_.insert(key);
    lock.unlock();  // the deleter runs if there is no memory for the pointer
    return {this, [this, key](void*) {
              {
                const std::lock_guard end(mutex_);
                taken_.erase(key);
              }
              over_.notify_all();
            }};
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
  std::deque<std::string> sources;           // its keys in `by_source`, the oldest first
};

/// What several scenes keep in memory: a scene without edits, or surfaces that edits moved.
struct Shared {
  std::size_t entries = 0;  // that keep it
  std::uint64_t bytes = 0;  // when last measured
};

/// Calls `f` with the address and the memory of all that the scene may share with others.
template <typename F>
void for_each_shared(const Scene& scene, const F& f) {
  const Scene& loaded = scene.without_edits();
  f(&loaded, loaded.own_bytes());
  if (&scene.geometry() != &loaded.geometry()) f(&scene.geometry(), scene.geometry().bytes());
}

/// The memory of a scene without all that for_each_shared() counts.
inline std::uint64_t unshared_bytes(const Scene& scene) {
  if (scene.loaded() == nullptr) return 0;
  return scene.own_bytes() - (scene.has_own_geometry() ? scene.geometry().bytes() : 0);
}

inline absl::Status over_quota(const std::string& what) {
  absl::Status status = absl::ResourceExhaustedError(what);
  status.SetPayload(kOverQuotaPayload, absl::Cord());
  return status;
}

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
  std::map<const void*, Shared> shared;
  std::uint64_t held = 0;  // bytes of all entries and of `shared`, each as last measured

  /// Scenes that are no longer held, with their bytes.  A call may still use them.
  std::vector<std::pair<std::weak_ptr<const Scene>, std::uint64_t>> removed;

  std::uint64_t loading = 0;          // bytes of running loads and calls
  std::multiset<std::string> in_use;  // ids of the scenes of calls whose memory counts

  // Loads take memory one after the other.  So none counts on what another gives back before the
  // operating system has it.
  std::mutex taking;
  std::atomic<std::uint64_t> freed = 0;  // by loads and scenes since memory was last returned

  /// The allocator keeps much of what is freed, in pieces between arrays that stay.  It must go
  /// back to the system before a load counts on it.  Call it with `taking` held.
  void return_if_much_was_freed() {
    const std::uint64_t budget = options.memory_budget_bytes;
    if (budget == 0 || freed.load() < std::max(kLeastFreed, budget / kFreedShare)) return;
    freed = 0;
    return_free_memory();
  }
  // This takes some milliseconds.
  static constexpr std::uint64_t kLeastFreed = std::uint64_t{8} << 20, kFreedShare = 32;

  LoadLimits load_limits(LoadBudget& budget) const {
    LoadLimits limits = options.load;
    if (options.texture_bytes > 0) limits.texture_bytes = options.texture_bytes;
    limits.budget = &budget;
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
    const std::uint64_t before = held;
    held -= entry->second.bytes;
    for_each_shared(*entry->second.stored.scene, [&](const void* what, std::uint64_t) {
      const auto of = shared.find(what);
      if (--of->second.entries > 0) return;
      held -= of->second.bytes;
      shared.erase(of);
    });
    freed += before - held;
    std::erase_if(removed, [](const auto& r) { return r.first.expired(); });
    removed.emplace_back(entry->second.stored.scene, before - held);
    gone.push_back(std::move(entry->second.stored.scene));
    scenes.erase(entry);
  }

  /// Measures a scene again, since queries may have built parts in it.
  void measure(Entry& entry) {
    const auto set = [this](std::uint64_t& bytes, std::uint64_t now) {
      held += now - bytes;
      bytes = now;
    };
    for_each_shared(*entry.stored.scene,
                    [&](const void* what, std::uint64_t bytes) { set(shared[what].bytes, bytes); });
    set(entry.bytes, unshared_bytes(*entry.stored.scene));
  }
  Entry& insert(Entry entry) {
    for_each_shared(*entry.stored.scene,
                    [&](const void* what, std::uint64_t) { ++shared[what].entries; });
    measure(entry);
    const std::string& id = entry.stored.scene->id();
    return scenes.emplace(id, std::move(entry)).first->second;
  }
  void measure_all() {
    for (auto& [id, entry] : scenes) measure(entry);
  }

  /// Whether evictions leave the scene in memory.
  bool stays(const std::string& id, Entry& entry) const {
    return leased_until(entry) || in_use.contains(id);
  }

  /// Unloads the least recently used scenes without a lease until all have at most `most` bytes.
  /// Never unloads `keep`.
  void shrink(std::uint64_t most, const std::string& keep,
              std::vector<std::shared_ptr<const Scene>>& gone) {
    while (held > most) {
      auto oldest = scenes.end();
      for (auto s = scenes.begin(); s != scenes.end(); ++s) {
        if (s->first == keep || stays(s->first, s->second)) continue;
        if (oldest == scenes.end() || s->second.used < oldest->second.used) oldest = s;
      }
      if (oldest == scenes.end()) return;
      remove(oldest, gone);
    }
  }

  /// Unloads scenes until there is room for `more` bytes of a scene that has `own` bytes already.
  /// Unloads none if leases, other loads and calls leave too little.  With `call_of`, the bytes are
  /// those of a call that uses this scene.
  absl::Status evict_for(std::uint64_t more, std::uint64_t own,
                         std::vector<std::shared_ptr<const Scene>>& gone,
                         const std::string& call_of = "") {
    const std::uint64_t budget = options.memory_budget_bytes;
    if (budget == 0) return absl::OkStatus();
    const std::uint64_t needed = own + more;
    const char* const what = call_of.empty() ? "scene" : "call";
    if (needed > budget)
      return absl::ResourceExhaustedError(
          fmt::format("the {} needs {}{} bytes, allowed: at most {}", what,
                      own > 0 ? "at least " : "", needed, budget));
    if (own > 0 && held + loading + more <= budget) return absl::OkStatus();
    measure_all();
    std::uint64_t leased = 0;
    std::optional<TimePoint> soonest;
    std::set<const void*> counted;
    for (auto& [id, entry] : scenes) {
      if (!stays(id, entry)) continue;
      leased += entry.bytes;
      for_each_shared(*entry.stored.scene, [&](const void* what, std::uint64_t) {
        if (counted.insert(what).second) leased += shared.at(what).bytes;
      });
      if (const auto until = leased_until(entry))
        soonest = std::min(soonest.value_or(*until), *until);
    }
    if (leased + loading + more > budget) {
      const std::uint64_t others = loading - own;
      absl::Status full = absl::ResourceExhaustedError(fmt::format(
          "the {} needs {}{} bytes, but {} {}{} of the server's {}", what,
          own > 0 ? "at least " : "", needed,
          in_use.empty() ? "leased scenes use" : "scenes that are leased or in use take", leased,
          others > 0 ? fmt::format(" and other loads and calls {}", others) : "", budget));
      // A load or a call may end at any time.
      auto wait = std::chrono::milliseconds(1000);
      if (others == 0 && soonest)
        wait = std::chrono::ceil<std::chrono::milliseconds>(*soonest - options.now());
      full.SetPayload(kRetryAfterPayload,
                      absl::Cord(std::to_string(std::max<std::int64_t>(wait.count(), 1))));
      return full;
    }
    shrink(budget - loading - more, "", gone);
    return absl::OkStatus();
  }

  /// Remembers that `key` gave the scene.  A scene has few sources: an old one is forgotten, and
  /// then read again when it is loaded.
  void remember(Entry& entry, const std::string& key) {
    constexpr std::size_t kMostSources = 64;
    const std::string id = entry.stored.scene->id();
    const auto [place, is_new] = by_source.try_emplace(key, id);
    if (!is_new && place->second == id) return;
    place->second = id;
    entry.sources.push_back(key);
    if (entry.sources.size() <= kMostSources) return;
    // It may give another scene by now.
    const auto oldest = by_source.find(entry.sources.front());
    if (oldest != by_source.end() && oldest->second == id) by_source.erase(oldest);
    entry.sources.pop_front();
  }

  /// The answer to a load from `key` of a scene that is in the store.
  LoadedScene answer(Entry& entry, const std::string& key, const LoadOptions& load,
                     bool already_loaded) {
    remember(entry, key);
    entry.used = ++uses;
    return {entry.stored, already_loaded, give_lease(entry, "", load.lease_s, load.owner), {}};
  }
};

/// The memory of one load, or of one call, as a part of the store's budget.
class SceneStore::LoadMemory final : public MemoryPool {
 public:
  explicit LoadMemory(State& state) : state_(state) {}
  /// Of a call that uses this scene.
  LoadMemory(State& state, std::string scene_id) : state_(state), call_of_(std::move(scene_id)) {
    const std::lock_guard lock(state_.mutex);
    state_.in_use.insert(call_of_);
  }
  ~LoadMemory() override {
    if (call_of_.empty()) return;
    const std::lock_guard lock(state_.mutex);
    state_.in_use.erase(state_.in_use.find(call_of_));
  }

  LoadBudget& budget() { return budget_; }
  /// An error of the load, which may be retried if the budget is to blame.
  absl::Status explained(absl::Status status) const {
    if (const auto retry = budget_.refusal().GetPayload(kRetryAfterPayload);
        absl::IsResourceExhausted(status) && retry)
      status.SetPayload(kRetryAfterPayload, *retry);
    return status;
  }
  /// Ends the counting: the scene is stored, or dropped.  Call it with the lock held.
  void end() {
    state_.loading -= own_;
    own_ = 0;
  }

  absl::Status take(std::uint64_t bytes) override {
    const std::lock_guard turn(state_.taking);
    {
      std::vector<std::shared_ptr<const Scene>> gone;  // destroyed outside of the lock
      const std::lock_guard lock(state_.mutex);
      LUCERNA_RETURN_IF_ERROR(state_.evict_for(bytes, own_, gone, call_of_));
      own_ += bytes;
      state_.loading += bytes;
    }
    state_.return_if_much_was_freed();
    return absl::OkStatus();
  }
  void give_back(std::uint64_t bytes) override {
    const std::lock_guard lock(state_.mutex);
    const std::uint64_t rest = std::min(bytes, own_);
    own_ -= rest;
    state_.loading -= rest;
    state_.freed += rest;
  }

 private:
  State& state_;
  const std::string call_of_;
  std::uint64_t own_ = 0;
  LoadBudget budget_{this};  // last member: gives its bytes back first
};

}  // namespace lucerna

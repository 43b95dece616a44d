// What a scene is made of, as GetScene lists it, and parts that are made when they are first asked
// for.
#pragma once

#include <atomic>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace lucerna {

class Stopwatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// One thing that was built, for GetScene.
struct ScenePart {
  std::string name;  ///< "bvh", "vertices", "lights", ...
  std::uint64_t bytes;
  double build_ms;
  std::string why;  ///< what of the scene, or which question, asked for it
};

/// What a scene keeps for code that the scene does not know: made when it is first used, freed with
/// the scene.  Its members may be called from any thread.
class AttachedPart {
 public:
  virtual ~AttachedPart() = default;
  /// Empty while nothing is built.
  virtual std::optional<ScenePart> report() const = 0;
  /// 0 while nothing is built.
  virtual std::uint64_t bytes() const = 0;
};

/// The attached parts of one scene, at most one of each type.  A list, as there are few: finding a
/// part takes one comparison for each.  All members may be called from any thread.
class AttachedParts {
 public:
  AttachedParts() = default;
  ~AttachedParts() {
    for (const Node* node = head_.load(); node != nullptr;) delete std::exchange(node, node->next);
  }
  AttachedParts(const AttachedParts&) = delete;
  AttachedParts& operator=(const AttachedParts&) = delete;

  /// The `T`, made by `T(source)` if this is its first use.
  template <std::derived_from<AttachedPart> T, typename Source>
  const T& get(const Source& source) const {
    if (const T* found = find<T>()) [[likely]]
      return *found;
    const std::lock_guard lock(mutex_);
    if (const T* found = find<T>()) return *found;
    auto part = std::make_unique<const T>(source);
    const T& made = *part;
    head_.store(new Node{&key<T>, std::move(part), head_.load(std::memory_order_relaxed)},
                std::memory_order_release);
    return made;
  }

  /// Calls `f` with each attached part, the last one first.
  template <typename F>
  void for_each(const F& f) const {
    for (const Node* node = head_.load(std::memory_order_acquire); node != nullptr;
         node = node->next)
      f(*node->part);
  }

 private:
  struct Node {
    const char* key;
    std::unique_ptr<const AttachedPart> part;
    const Node* next;
  };
  // Its address names the type.
  template <typename T>
  static constexpr char key = 0;

  template <typename T>
  const T* find() const {
    for (const Node* node = head_.load(std::memory_order_acquire); node != nullptr;
         node = node->next)
      if (node->key == &key<T>) return static_cast<const T*>(node->part.get());
    return nullptr;
  }

  mutable std::mutex mutex_;
  mutable std::atomic<const Node*> head_{nullptr};
};

/// A part that no scene pays for before somebody asks for it: made once, by whoever is first, while
/// others that ask for it wait.  `T` tells its `bytes()`.  All members may be called from any
/// thread.
template <typename T>
class LazyPart {
 public:
  explicit LazyPart(std::string name) : name_(std::move(name)) {}

  /// The part; made by `make()`, a std::unique_ptr<const T>, with the reason `why(part)`, if nobody
  /// did before.  Where `make` throws nothing is kept, and whoever asks next makes it again.
  ///
  /// `make` may use the threads of the caller's arena through parallel_chunks alone: in that a
  /// thread that waits takes no work from outside of the loop, which might ask for this very part
  /// and wait for itself.
  template <typename Make, typename Why>
  const T& get(const Make& make, const Why& why) const {
    if (const T* made = made_.load(std::memory_order_acquire)) return *made;
    const std::lock_guard lock(mutex_);
    if (part_ == nullptr) {
      const Stopwatch watch;
      std::shared_ptr<const T> part = make();
      told_ = {name_, part->bytes(), watch.ms(), why(*part)};
      part_ = std::move(part);
      bytes_.store(told_.bytes, std::memory_order_relaxed);
      made_.store(part_.get(), std::memory_order_release);
    }
    return *part_;
  }

  /// Null where it was not made yet, as below.
  const T* made() const { return made_.load(std::memory_order_acquire); }
  /// Nothing where it was not made yet.  Does not wait for who is making it.
  std::optional<ScenePart> told() const {
    if (made_.load(std::memory_order_acquire) == nullptr) return std::nullopt;
    return told_;
  }
  /// 0 where it was not made yet.
  std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }

 private:
  const std::string name_;
  mutable std::mutex mutex_;
  mutable std::atomic<const T*> made_{nullptr};
  mutable std::atomic<std::uint64_t> bytes_{0};
  // Written once, with the lock held, before made_ is; a shared_ptr as T may be incomplete here.
  mutable std::shared_ptr<const T> part_;
  mutable ScenePart told_{};
};

}  // namespace lucerna

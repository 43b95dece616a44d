// The parts of a scene, as GetScene lists them, and parts that are made at their first use.
#pragma once

#include <algorithm>
#include <atomic>
#include <concepts>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/common/stopwatch.h"

namespace lucerna {

/// A part that is built, for GetScene.
struct ScenePart {
  std::string name;  ///< "bvh", "vertices", "lights", ...
  std::uint64_t bytes;
  double build_ms;
  std::string why;  ///< the reason: a property of the scene, or the query that needed it
};

inline std::uint64_t bytes_of(const std::vector<ScenePart>& parts) {
  std::uint64_t sum = 0;
  for (const ScenePart& part : parts) sum += part.bytes;
  return sum;
}

/// Data that other code keeps with a scene: made at its first use, freed with the scene.
/// Members may be called from any thread.
class AttachedPart {
 public:
  virtual ~AttachedPart() = default;
  /// Nothing until it is built.
  virtual std::optional<ScenePart> report() const = 0;
  /// 0 until it is built.
  virtual std::uint64_t bytes() const = 0;
};

/// The attached parts of one scene, at most one of each type.  They form a list, because there are
/// few; finding a part takes one comparison for each.  All members may be called from any thread.
class AttachedParts {
 public:
  AttachedParts() = default;
  ~AttachedParts() {
    for (const Node* node = head_.load(); node != nullptr;) delete std::exchange(node, node->next);
  }
  AttachedParts(const AttachedParts&) = delete;
  AttachedParts& operator=(const AttachedParts&) = delete;

  /// Returns the `T`; makes it by `T(source)` at its first use.
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

  /// Adds the reports of those that are built, by name: the order of first uses may differ.
  void add_reports(std::vector<ScenePart>& parts) const {
    const auto from = static_cast<std::ptrdiff_t>(parts.size());
    for (const Node* node = head_.load(std::memory_order_acquire); node != nullptr;
         node = node->next)
      if (auto part = node->part->report()) parts.push_back(*std::move(part));
    std::ranges::sort(parts.begin() + from, parts.end(), {}, &ScenePart::name);
  }
  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const Node* node = head_.load(std::memory_order_acquire); node != nullptr;
         node = node->next)
      sum += node->part->bytes();
    return sum;
  }

 private:
  struct Node {
    const char* key;
    std::unique_ptr<const AttachedPart> part;
    const Node* next;
  };
  // The address identifies the type.
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

/// A part that is made at its first use, once.  Other threads that need it wait meanwhile.  `T`
/// has `bytes()`.  All members may be called from any thread.
template <typename T>
class LazyPart {
 public:
  explicit LazyPart(std::string name) : name_(std::move(name)) {}

  /// Returns the part.  At the first call `make()` returns it as std::unique_ptr<const T>, and
  /// `why(part)` is its reason.  If `make` throws, nothing is kept, and the next call tries again.
  ///
  /// `make` may use the threads of the caller's arena only through parallel_chunks.  There, a
  /// waiting thread takes no work from outside of the loop.  Such work might need this part and
  /// cause a deadlock.
  template <typename Make, typename Why>
  const T& get(const Make& make, const Why& why) const {
    if (const T* made = made_.load(std::memory_order_acquire)) return *made;
    const std::lock_guard lock(mutex_);
    if (part_ == nullptr) {
      const Stopwatch watch;
      std::shared_ptr<const T> part = make();
      report_ = {name_, part->bytes(), 1e3 * watch.seconds(), why(*part)};
      part_ = std::move(part);
      bytes_.store(report_.bytes, std::memory_order_relaxed);
      made_.store(part_.get(), std::memory_order_release);
    }
    return *part_;
  }

  /// Null until it is made.
  const T* made() const { return made_.load(std::memory_order_acquire); }
  /// Nothing until it is made.  Does not wait for a thread that is making it.
  std::optional<ScenePart> report() const {
    if (made_.load(std::memory_order_acquire) == nullptr) return std::nullopt;
    return report_;
  }
  /// 0 until it is made.
  std::uint64_t bytes() const { return bytes_.load(std::memory_order_relaxed); }

 private:
  const std::string name_;
  mutable std::mutex mutex_;
  mutable std::atomic<const T*> made_{nullptr};
  mutable std::atomic<std::uint64_t> bytes_{0};
  // Written once under the lock, before made_.  A shared_ptr, because T may be incomplete
  // here.
  mutable std::shared_ptr<const T> part_;
  mutable ScenePart report_{};
};

/// An attached part that is one LazyPart.  `T` is made by `T(source)` and has `kPartName`, `why()`
/// and `bytes()`.
template <typename T, typename Source>
class AttachedLazyPart final : public AttachedPart {
 public:
  explicit AttachedLazyPart(const Source& source) : source_(source) {}

  const T& get() const {
    return part_.get([this] { return std::make_unique<const T>(source_); },
                     [](const T& part) { return part.why(); });
  }
  std::optional<ScenePart> report() const override { return part_.report(); }
  std::uint64_t bytes() const override { return part_.bytes(); }

 private:
  const Source& source_;
  LazyPart<T> part_{T::kPartName};
};

}  // namespace lucerna

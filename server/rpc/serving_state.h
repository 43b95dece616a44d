// Whether the server takes calls, for those who ask for its health.
#pragma once

#include <functional>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace lucerna::rpc {

/// Serves until it stops, once.  Thread-safe.
class ServingState {
 public:
  bool serving() const {
    const std::lock_guard lock(mutex_);
    return serving_;
  }
  /// Calls `stopped` when the server stops serving, unless `who` forgets it before.  False if the
  /// server has stopped; then nothing is called.
  bool watch(const void* who, std::function<void()> stopped) {
    const std::lock_guard lock(mutex_);
    if (serving_) watchers_[who] = std::move(stopped);
    return serving_;
  }
  void forget(const void* who) {
    const std::lock_guard lock(mutex_);
    watchers_.erase(who);
  }
  void stop() {
    std::unordered_map<const void*, std::function<void()>> watchers;
    {
      const std::lock_guard lock(mutex_);
      serving_ = false;
      watchers.swap(watchers_);
    }
    for (const auto& [who, stopped] : watchers) stopped();
  }

 private:
  mutable std::mutex mutex_;
  bool serving_ = true;
  std::unordered_map<const void*, std::function<void()>> watchers_;
};

}  // namespace lucerna::rpc

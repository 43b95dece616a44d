// Calls that wait for a message of their client, and when they give up.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <utility>

namespace lucerna::rpc {

/// Thread-safe.
class Waits {
 public:
  using Clock = std::chrono::steady_clock;
  struct Wait {
    Clock::time_point end;
    std::uint64_t id = 0;  ///< no other wait has it; never 0
    auto operator<=>(const Wait&) const = default;
  };

  Wait until(Clock::time_point end) { return {end, ++ids_}; }
  /// `give_up` is called when the wait's time has come, unless the wait is removed before.
  void add(const Wait& wait, std::function<void()> give_up) {
    const std::lock_guard lock(mutex_);
    waits_.emplace(wait, std::move(give_up));
  }
  void remove(const Wait& wait) {
    const std::lock_guard lock(mutex_);
    waits_.erase(wait);
  }
  /// Ends the waits whose time has come.  Call it some times a second.
  void watch() {
    for (;;) {
      std::function<void()> give_up;
      {
        const std::lock_guard lock(mutex_);
        if (waits_.empty() || waits_.begin()->first.end > Clock::now()) return;
        give_up = std::move(waits_.extract(waits_.begin()).mapped());
      }
      give_up();
    }
  }

 private:
  std::atomic<std::uint64_t> ids_ = 0;
  std::mutex mutex_;
  std::map<Wait, std::function<void()>> waits_;
};

}  // namespace lucerna::rpc

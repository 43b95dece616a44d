// Limits how many items a caller computes in a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>

namespace lucerna::access {

/// A token bucket that holds the items of one second.  Thread-safe.
///
/// A request larger than the bucket needs a full one.  It leaves a debt, which later requests wait
/// for.  So no request is too large for ever, and the rate holds over time.
class ItemBucket {
 public:
  using Clock = std::chrono::steady_clock;

  /// Takes `items`, and returns 0.  If they are not there, takes nothing and returns the time after
  /// which they are, if nobody else takes any.  `per_second`: the rate, which may change from call
  /// to call; 0: no limit.
  std::chrono::milliseconds take(std::uint64_t items, std::uint64_t per_second,
                                 Clock::time_point now = Clock::now());
  /// Takes `items` that were computed already, also if they are not there.
  void owe(std::uint64_t items);

 private:
  std::mutex mutex_;
  double missing_ = 0;  // items that a full bucket has and this one has not
  Clock::time_point filled_{};
};

}  // namespace lucerna::access

#include "server/rpc/item_bucket.h"

#include <algorithm>
#include <cmath>

namespace lucerna::access {

std::chrono::milliseconds ItemBucket::take(std::uint64_t items, std::uint64_t per_second,
                                           Clock::time_point now) {
  if (items == 0 || per_second == 0) return std::chrono::milliseconds(0);
  const auto rate = static_cast<double>(per_second);
  const auto wanted = static_cast<double>(items);
  const std::lock_guard lock(mutex_);
  if (now > filled_) {
    const double passed_s = std::chrono::duration<double>(now - filled_).count();
    missing_ = std::max(0.0, missing_ - rate * passed_s);
    filled_ = now;
  }
  const double most_missing = rate - std::min(wanted, rate);
  if (missing_ > most_missing) {
    // Rounded up: a retry that comes too early is refused again.
    const double wait_ms = std::ceil(1e3 * (missing_ - most_missing) / rate);
    return std::chrono::milliseconds(std::max<std::int64_t>(1, std::llround(wait_ms)));
  }
  missing_ += wanted;
  return std::chrono::milliseconds(0);
}

void ItemBucket::owe(std::uint64_t items) {
  const std::lock_guard lock(mutex_);
  missing_ += static_cast<double>(items);
}

}  // namespace lucerna::access

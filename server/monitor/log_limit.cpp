#include "server/monitor/log_limit.h"

#include <algorithm>
#include <utility>

namespace lucerna::monitor {

LogLimit::LogLimit(std::uint64_t lines_per_second, std::function<Clock::time_point()> now)
    : rate_(static_cast<double>(lines_per_second)),
      now_(std::move(now)),
      tokens_(rate_),
      filled_(now_()) {}

std::optional<std::uint64_t> LogLimit::take() {
  if (rate_ == 0) return 0;
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = now_();
  tokens_ = std::min(rate_, tokens_ + rate_ * std::chrono::duration<double>(now - filled_).count());
  filled_ = now;
  if (tokens_ < 1) {
    ++left_out_;
    return std::nullopt;
  }
  tokens_ -= 1;
  return left_out_ - std::exchange(reported_, left_out_);
}

std::uint64_t LogLimit::left_out() const {
  const std::lock_guard lock(mutex_);
  return left_out_;
}

}  // namespace lucerna::monitor

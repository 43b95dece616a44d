#include "server/monitor/log_limit.h"

#include <fmt/format.h>

#include <algorithm>

namespace lucerna::monitor {

LogLimit::LogLimit(std::shared_ptr<spdlog::sinks::sink> out, std::uint64_t lines_per_second,
                   std::function<Clock::time_point()> now)
    : out_(std::move(out)),
      rate_(static_cast<double>(lines_per_second)),
      now_(std::move(now)),
      tokens_(rate_),
      filled_(now_()) {}

bool LogLimit::take() {
  if (rate_ == 0) return true;
  std::uint64_t missing = 0;
  {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = now_();
    const double passed_s = std::chrono::duration<double>(now - filled_).count();
    tokens_ = std::min(rate_, tokens_ + rate_ * passed_s);
    filled_ = now;
    if (tokens_ < 1) {
      ++left_out_;
      return false;
    }
    tokens_ -= 1;
    missing = left_out_ - std::exchange(reported_, left_out_);
  }
  if (missing == 0) return true;
  const std::string text =
      fmt::format("{} lines were left out, because there were too many in a second", missing);
  // Without the name of a logger, its text is not the members of a JSON object.
  out_->log(spdlog::details::log_msg("", spdlog::level::warn, text));
  return true;
}

std::uint64_t LogLimit::left_out() const {
  const std::lock_guard lock(mutex_);
  return left_out_;
}

}  // namespace lucerna::monitor

// Limits how many lines a log gets in a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>

namespace lucerna::monitor {

/// A token bucket: at most `lines_per_second` lines in a burst, and as many in each further second.
/// Thread-safe.
class LogLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// 0: no limit.  `now` is the clock.
  explicit LogLimit(std::uint64_t lines_per_second,
                    std::function<Clock::time_point()> now = &Clock::now);

  /// Nothing if the line must be left out.  Else the number of lines that were left out since the
  /// last line that was not.
  std::optional<std::uint64_t> take();
  /// All lines left out so far.
  std::uint64_t left_out() const;

 private:
  const double rate_;
  const std::function<Clock::time_point()> now_;
  mutable std::mutex mutex_;
  double tokens_;
  Clock::time_point filled_;
  std::uint64_t left_out_ = 0, reported_ = 0;
};

}  // namespace lucerna::monitor

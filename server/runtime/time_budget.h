// Takes as many samples as fit into a given time.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

namespace lucerna {

/// The share of a time budget that is planned for.  The rest is a reserve.
inline constexpr double kPlannedShare = 0.9;
/// A longer budget counts as this one, 30 years.  Otherwise it would overflow the clock.
inline constexpr double kLongestBudgetS = 1e9;

/// Requests a stop at a moment, or when another stop is requested.
class StopAt {
 public:
  using Clock = std::chrono::steady_clock;
  StopAt(Clock::time_point when, const std::stop_token& stop)
      : forward_(stop, [this] { source_.request_stop(); }),
        timer_([this, when](const std::stop_token& over) {
          std::unique_lock lock(mutex_);
          woken_.wait_until(lock, over, when, [] { return false; });
          if (!over.stop_requested()) source_.request_stop();
        }) {}

  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::stop_callback<std::function<void()>> forward_;
  std::mutex mutex_;
  std::condition_variable_any woken_;
  std::jthread timer_;
};

/// Calls `run(n, stop)` for larger and larger n until `budget_s` is over, and returns the last
/// answer and its n.  `run` takes n new samples and returns their answer, or nothing if it was
/// stopped.  n is chosen by the clock before the samples are taken, so the estimate stays unbiased.
/// The first answer, of one sample, is always completed.  Nothing if `stop` was requested. `round`
/// rounds a count down to an allowed one; 1 is always allowed.
template <typename Run, typename Round = std::identity>
auto within_time(double budget_s, std::uint32_t most, const std::stop_token& stop, Run&& run,
                 Round&& round = {}) -> decltype(std::pair(run(1U, stop), 1U)) {
  // The time of a short run does not predict the time of a long one well.
  constexpr double kMostGrowth = 16;
  using Clock = StopAt::Clock;
  const auto begin = Clock::now();
  const auto since = [](Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
  };
  std::pair best(run(1U, stop), 1U);
  double took_s = since(begin);
  while (best.first && best.second < most) {
    const double left_s = std::min(budget_s, kLongestBudgetS) - since(begin);
    const double fits =
        std::min(kPlannedShare * left_s / std::max(took_s, 1e-9), kMostGrowth) * best.second;
    const std::uint32_t n = round(static_cast<std::uint32_t>(std::clamp<double>(fits, 0, most)));
    if (n <= best.second) break;
    const StopAt in_time(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                            std::chrono::duration<double>(left_s)),
                         stop);
    const auto start = Clock::now();
    auto answer = run(n, in_time.token());
    took_s = since(start);
    if (stop.stop_requested()) best.first = {};
    if (!answer) break;
    best = {std::move(answer), n};
  }
  return best;
}

}  // namespace lucerna

// As many samples as fit into a time.
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

/// Asks for a stop at a moment, or when another stop is asked for.
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

/// Calls `run(n, stop)`, which takes n samples anew and returns what they say or nothing where it
/// was stopped, for larger and larger n until `budget_s` is over; returns the last answer and its
/// n.  A count is chosen by the clock before its samples are taken, so they have no say in it.
/// The first answer, of one sample, is waited for.  Nothing where `stop` was asked for.
/// `round` takes a count down to one that can be asked for, of which 1 is one.
template <typename Run, typename Round = std::identity>
auto within_time(double budget_s, std::uint32_t most, const std::stop_token& stop, Run&& run,
                 Round&& round = {}) -> decltype(std::pair(run(1U, stop), 1U)) {
  // What is left of the budget is never planned to the last moment.
  constexpr double kPlanned = 0.9;
  // Short runs tell little of long ones.
  constexpr double kMostGrowth = 16;
  // What clocks can add to now: 30 years.
  constexpr double kForEver = 1e9;
  using Clock = StopAt::Clock;
  const auto begin = Clock::now();
  const auto since = [](Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
  };
  std::pair best(run(1U, stop), 1U);
  double took_s = since(begin);
  while (best.first && best.second < most) {
    const double left_s = std::min(budget_s, kForEver) - since(begin);
    const double fits =
        std::min(kPlanned * left_s / std::max(took_s, 1e-9), kMostGrowth) * best.second;
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

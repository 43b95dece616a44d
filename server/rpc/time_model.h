// Learns how long predicted work really takes, so that work which cannot meet its deadline is not
// started.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>

#include "server/monitor/calls.h"

namespace lucerna::rpc {

/// Predictions are upper estimates.  The model keeps, for each kind of call, the least ratio of the
/// wall time to the prediction.  The least ratio fades slowly (kForget).  So the model refuses
/// only work that would be late even in the easiest case.  It also keeps the mean of the last
/// ratios.  Lanes use it to choose the next waiting call.  Thread-safe.
class TimeModel {
 public:
  /// The work of a call has ended.  Short work says little about long work.
  void learn(monitor::Call call, double predicted_s, double wall_s) {
    if (predicted_s <= 0 || wall_s < kLeastSeconds) return;
    calls_[static_cast<std::size_t>(call)].fetch_add(1, std::memory_order_relaxed);
    const double ratio = wall_s / predicted_s;
    std::atomic<double>& least = ratios_[static_cast<std::size_t>(call)];
    const double old = least.load(std::memory_order_relaxed);
    // Two threads may overwrite each other.  Then the model learns from one of them only.
    least.store(old == 0 ? ratio : std::min(ratio, kForget * old), std::memory_order_relaxed);
    std::atomic<double>& mean = means_[static_cast<std::size_t>(call)];
    const double before = mean.load(std::memory_order_relaxed);
    mean.store(before == 0 ? ratio : before + kWeight * (ratio - before),
               std::memory_order_relaxed);
  }

  /// About how long the work takes [s]; 0 if nothing is known.
  double expected_seconds(monitor::Call call, double predicted_s) const {
    return predicted_s * means_[static_cast<std::size_t>(call)].load(std::memory_order_relaxed);
  }

  /// The least time that the work takes [s]; 0 if too little is known.
  double least_seconds(monitor::Call call, double predicted_s) const {
    if (calls_[static_cast<std::size_t>(call)].load(std::memory_order_relaxed) < kLeastCalls)
      return 0;
    return kCaution * predicted_s *
           ratios_[static_cast<std::size_t>(call)].load(std::memory_order_relaxed);
  }

 private:
  static constexpr double kLeastSeconds = 1e-3;
  // The first calls of a server build parts of scenes.  They take longer than later ones, and a
  // prediction from one of them refused work that had enough time.
  static constexpr unsigned kLeastCalls = 8;
  // The least ratio rises by this factor with each call that is not faster.  After 70 calls it has
  // doubled, so an easy scene of the past no longer decides.
  static constexpr double kForget = 1.01;
  // The machine may be less busy than it was in all earlier calls.
  static constexpr double kCaution = 0.5;

  // Of the last call in the mean.
  static constexpr double kWeight = 0.1;

  std::array<std::atomic<double>, monitor::kCalls> ratios_{}, means_{};
  std::array<std::atomic<unsigned>, monitor::kCalls> calls_{};
};

}  // namespace lucerna::rpc

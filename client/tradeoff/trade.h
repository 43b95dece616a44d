// Runs a whole study of one question: reference, sweep, analysis.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client/tradeoff/record.h"

namespace lucerna::tradeoff {

struct TradeOptions {
  /// Time of the study [s].  The reference gets at most half of it, and the sweep the rest.
  double budget_s = 60;
  /// If above 0, the study ignores `budget_s` and ends after this number of rounds.  Its amounts
  /// are then 1, 4, 16 ... up to `max_samples` samples, and target errors of 30% and 10%.  They do
  /// not depend on the speed of the machine.
  std::uint32_t rounds = 0;
  std::uint32_t max_samples = 64;
  std::uint64_t seed = 0;
  Clock clock{};
  /// Receives one line of progress.
  std::function<void(const std::string&)> on_event = [](const std::string&) {};
};

/// Measures everything in the record.  The caller sets most of the circumstances.  `question` must
/// outlive the record.  DEADLINE_EXCEEDED, with the required time, if the budget is too short.
absl::StatusOr<Record> measure_trade(Question& question, const TradeOptions& options);

}  // namespace lucerna::tradeoff

// A whole study of one question: reference, sweep, analysis.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client/tradeoff/record.h"

namespace lucerna::tradeoff {

struct TradeOptions {
  /// Seconds of the study.  The reference gets half of them at most, the sweep the rest.
  double budget_s = 60;
  /// If above 0, the study ignores `budget_s` and ends after so many rounds.  Then its amounts are
  /// 1, 4, 16 ... up to `max_samples` samples and target errors of 30% and 10%, and what it
  /// measures does not depend on the speed of the machine.
  std::uint32_t rounds = 0;
  std::uint32_t max_samples = 64;
  std::uint64_t seed = 0;
  Clock clock{};
  /// Receives one line of progress.
  std::function<void(const std::string&)> on_event = [](const std::string&) {};
};

/// Fills in all of the record but most circumstances.  `question` must outlive the record.
/// DEADLINE_EXCEEDED, with the time it needs, if the budget is too short.
absl::StatusOr<Record> measure_trade(Question& question, const TradeOptions& options);

}  // namespace lucerna::tradeoff

// Reference, sweep and analysis of one question, one after the other.
#pragma once

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client/tradeoff/record.h"

namespace lucerna::tradeoff {

struct TradeOptions {
  double budget_s = 60;  ///< for all of it
  std::uint64_t seed = 0;
  Clock clock{};
  std::function<void(const std::string&)> on_event = [](const std::string&) {};
};

/// Half of the time at most makes the reference, the rest sweeps.  All but the circumstances is
/// filled in; `question` must outlive the record.  DEADLINE_EXCEEDED, with what is missing, for too
/// short a budget.
absl::StatusOr<Record> measure_trade(Question& question, const TradeOptions& options);

}  // namespace lucerna::tradeoff

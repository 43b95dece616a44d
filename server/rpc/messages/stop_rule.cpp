#include "server/rpc/messages/stop_rule.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "proto/common/status_macros.h"
#include "server/rpc/messages/checks.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

absl::StatusOr<TargetError> check_target(const CallContext& context, const v1::TargetError& error) {
  const auto bad = [](const char* field, const auto& value, const std::string& allowed) {
    return bad_field(fmt::format("accuracy.target_error.{}", field), value, "{}", allowed);
  };
  TargetError target;
  target.relative = error.relative();
  if (!(target.relative > 0) || !std::isfinite(target.relative))
    return bad("relative", target.relative, "finite and more than 0");
  target.absolute_floor = error.absolute_floor();
  if (!(target.absolute_floor >= 0) || !std::isfinite(target.absolute_floor))
    return bad("absolute_floor", target.absolute_floor, "finite and not negative");
  if (error.has_confidence()) {
    target.confidence = error.confidence();
    if (!(target.confidence > 0 && target.confidence < 1))
      return bad("confidence", target.confidence, "more than 0 and less than 1");
  }
  const std::uint32_t most = context.limits.max_samples;
  target.max_samples = std::min<std::uint64_t>(target.max_samples, most);
  if (error.has_max_samples()) {
    if (error.max_samples() < kLeastTargetSamples || error.max_samples() > most)
      return bad("max_samples", error.max_samples(),
                 fmt::format("[{}, {}]", kLeastTargetSamples, most));
    target.max_samples = error.max_samples();
  }
  return target;
}

}  // namespace

std::uint32_t blocks_of(std::uint32_t samples) {
  if (samples <= kDefaultBlocks) return samples;
  for (std::uint32_t n = kDefaultBlocks; n <= samples / n; ++n)
    if (samples % n == 0) return n;
  for (std::uint32_t each = kDefaultBlocks; each > 1; --each)
    if (samples % each == 0 && samples / each >= kDefaultBlocks) return samples / each;
  return samples;
}

absl::StatusOr<StopRule> check_stop_rule(const CallContext& context, const v1::Accuracy& accuracy,
                                         std::uint32_t fallback) {
  StopRule rule;
  if (accuracy.has_target_error()) {
    LUCERNA_ASSIGN_OR_RETURN(rule.target, check_target(context, accuracy.target_error()));
  } else if (accuracy.has_time_budget_s()) {
    const double budget = accuracy.time_budget_s();
    if (!(budget > 0) || !std::isfinite(budget))
      return bad_field("accuracy.time_budget_s", budget, "finite and more than 0 s");
    rule.time_budget_s = budget;
  } else {
    LUCERNA_ASSIGN_OR_RETURN(rule.samples, check_samples(context, accuracy, fallback));
  }
  return rule;
}

}  // namespace lucerna::rpc

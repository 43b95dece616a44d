// The accuracy that a request asks for: when a computation stops, and by which methods.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "lucerna/v1/accuracy.pb.h"
#include "server/estimate/methods.h"
#include "server/estimate/pilots.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

/// Exactly one of the three is set.
struct StopRule {
  std::uint32_t samples = 0;  ///< 0: another one is set
  std::optional<TargetError> target{};
  std::optional<double> time_budget_s{};
};

/// `fallback`: the default number of samples.  INVALID_ARGUMENT for a field out of range.
absl::StatusOr<StopRule> check_stop_rule(const CallContext& context, const v1::Accuracy& accuracy,
                                         std::uint32_t fallback);

/// The least number of equal blocks, at least kDefaultBlocks, that divides `samples`.  If there
/// are fewer samples: `samples` itself.
std::uint32_t blocks_of(std::uint32_t samples);

/// An unset field is automatic.  INVALID_ARGUMENT for a field out of range.
absl::StatusOr<Methods> check_methods(const v1::Accuracy& accuracy);

}  // namespace lucerna::rpc

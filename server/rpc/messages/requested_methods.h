// The ways in which a request wants its answer made.
#pragma once

#include <absl/status/statusor.h>

#include "lucerna/v1/accuracy.pb.h"
#include "server/estimate/lights/methods.h"

namespace lucerna::rpc {

/// What is unset is automatic.  INVALID_ARGUMENT for what is out of range.
absl::StatusOr<Methods> check_methods(const v1::Accuracy& accuracy);

}  // namespace lucerna::rpc

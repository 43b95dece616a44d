// The methods that a request selects.
#pragma once

#include <absl/status/statusor.h>

#include "lucerna/v1/accuracy.pb.h"
#include "server/estimate/methods.h"

namespace lucerna::rpc {

/// An unset field is automatic.  INVALID_ARGUMENT for a field out of range.
absl::StatusOr<Methods> check_methods(const v1::Accuracy& accuracy);

}  // namespace lucerna::rpc

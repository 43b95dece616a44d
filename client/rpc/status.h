// Converts gRPC's status to Abseil's.  Not installed, since it names types of gRPC.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace lucerna::client {

/// The same code.  The field violations of the details are appended to the message, each as ";
/// FIELD: WHAT", unless it has them already.  kStatusPayloadUrl holds the bytes of the details.
absl::Status to_absl_status(const grpc::Status& status);

}  // namespace lucerna::client

// From gRPC's status to Abseil's.  Not installed: it names gRPC's types.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace lucerna::client {

/// The same code; the message with the field violations of the details added, each as "; FIELD:
/// WHAT", unless it has them already; the details' bytes under kStatusPayloadUrl.
absl::Status to_absl_status(const grpc::Status& status);

}  // namespace lucerna::client

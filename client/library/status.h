// Converts gRPC's status to Abseil's.  This header is not installed, since it uses types of gRPC.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace lucerna::client {

/// Converts the code, the message and the details.  Appends each field violation of the details to
/// the message as "; FIELD: WHAT", unless the message has it already.  The payload
/// kStatusPayloadUrl holds the bytes of the details.
absl::Status to_absl_status(const grpc::Status& status);

}  // namespace lucerna::client

// Reads from a server's error when to retry.
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/status.h"

namespace lucerna::client {

/// The delay of the error's google.rpc.RetryInfo; nothing if it has none.
std::optional<std::chrono::milliseconds> retry_delay(const absl::Status& status);

}  // namespace lucerna::client

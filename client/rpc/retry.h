// What a server's error says of trying again.
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/status.h"

namespace lucerna::client {

/// The delay of its google.rpc.RetryInfo; nothing where it has none.
std::optional<std::chrono::milliseconds> retry_delay(const absl::Status& status);

}  // namespace lucerna::client

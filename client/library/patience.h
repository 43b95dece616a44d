// Waits a limited time for functions that cannot be stopped.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace lucerna::client {

using LookUp = std::function<absl::StatusOr<std::vector<std::string>>()>;

/// Returns look_up(name) if it answers within `patience`, else UNAVAILABLE.  `look_up` runs in a
/// separate thread.  It may outlive this call, so it must own everything that it uses.
absl::StatusOr<std::vector<std::string>> look_up_within(std::chrono::seconds patience,
                                                        const std::string& name, LookUp look_up);

}  // namespace lucerna::client

// Waiting for what cannot be told to stop.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace lucerna::client {

using LookUp = std::function<absl::StatusOr<std::vector<std::string>>()>;

/// What `look_up` answers of `name` within `patience`, else UNAVAILABLE.  It runs in a thread of
/// its own, which may be left behind and must own all that it touches.
absl::StatusOr<std::vector<std::string>> look_up_within(std::chrono::seconds patience,
                                                        const std::string& name, LookUp look_up);

}  // namespace lucerna::client

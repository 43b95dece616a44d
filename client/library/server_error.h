// Names the server in an error.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace lucerna::client {

/// `status` with the server's name before the message; code and details stay.
inline absl::Status from_server(const std::string& target, const absl::Status& status) {
  absl::Status result(status.code(), target + ": " + std::string(status.message()));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { result.SetPayload(url, payload); });
  return result;
}

}  // namespace lucerna::client

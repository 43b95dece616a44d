// What a server said, told of that server.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace lucerna::client {

/// With the server's name before the message; the code and the details stay.
inline absl::Status from_server(const std::string& target, const absl::Status& status) {
  absl::Status result(status.code(), target + ": " + std::string(status.message()));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { result.SetPayload(url, payload); });
  return result;
}

}  // namespace lucerna::client

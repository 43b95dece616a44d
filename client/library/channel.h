// Connections to servers: retries, keep-alive, several servers in turn.  This header is not
// installed.
#pragma once

#include <memory>

#include "lucerna/client/client.h"

namespace grpc {
class Channel;
}

namespace lucerna::client {

/// Creates a channel; nothing is sent yet.  INVALID_ARGUMENT as for Client::connect.
absl::StatusOr<std::shared_ptr<grpc::Channel>> make_channel(const ConnectOptions& options);

}  // namespace lucerna::client

// How servers are connected to: retries, keep-alive, several of them in turn.  Not installed.
#pragma once

#include <memory>

#include "lucerna/client/client.h"

namespace grpc {
class Channel;
}

namespace lucerna::client {

/// Nothing is sent yet.
std::shared_ptr<grpc::Channel> make_channel(const ConnectOptions& options);

}  // namespace lucerna::client

// The servers that a target of gRPC names.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/common/host_port.h"

namespace lucerna::client {

/// The servers of "HOST:PORT", "dns:///HOST:PORT", "dns:HOST:PORT", "ipv4:A:PORT,B:PORT" or
/// "ipv6:[A]:PORT,...".  Empty for a target that gRPC finds in another way, such as "unix:PATH".
///
/// INVALID_ARGUMENT for a server without a host, or with a port outside of 1 to 65535.  gRPC takes
/// such a port modulo 65536, and connects to another server.
absl::StatusOr<std::vector<HostPort>> servers_of(const std::string& target);

/// Whether the target is a list of addresses: "ipv4:..." or "ipv6:...".
bool is_list(const std::string& target);

}  // namespace lucerna::client

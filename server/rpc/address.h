// HOST:PORT.
#pragma once

#include <absl/status/status.h>

#include <string>

namespace lucerna::rpc {

/// INVALID_ARGUMENT where it is not HOST:PORT with a port in [0, 65535]; hosts of IPv6 are in
/// brackets.
absl::Status check_address(const std::string& address);
/// The address with another port.
std::string with_port(const std::string& address, int port);
/// What the operating system says when it is asked for this address, e.g. "address in use".
std::string why_not_to_listen(const std::string& address);

}  // namespace lucerna::rpc

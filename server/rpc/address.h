// Addresses to listen on: HOST:PORT.
#pragma once

#include <absl/status/status.h>

#include <string>

namespace lucerna::rpc {

/// INVALID_ARGUMENT if it is not HOST:PORT with a port in [0, 65535].  IPv6 hosts are in brackets.
absl::Status check_address(const std::string& address);
/// The address with another port.
std::string with_port(const std::string& address, int port);
/// The reason why the operating system refuses to listen on this address, e.g. "address in use".
std::string why_not_to_listen(const std::string& address);

}  // namespace lucerna::rpc

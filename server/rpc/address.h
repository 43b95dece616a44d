// Addresses to listen on: HOST:PORT.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <netdb.h>

#include <memory>
#include <string>

namespace lucerna::rpc {

/// INVALID_ARGUMENT with the name of the setting if the address is not HOST:PORT with a port from 0
/// to 65535.  IPv6 hosts are in brackets.
absl::Status check_address(const std::string& setting, const std::string& address);
/// A valid address with another port.
std::string with_port(const std::string& address, int port);

struct FreeAddresses {
  void operator()(addrinfo* list) const { freeaddrinfo(list); }
};
using AddressList = std::unique_ptr<addrinfo, FreeAddresses>;
/// All addresses of the host, to listen on.  UNAVAILABLE if the host has none.
absl::StatusOr<AddressList> resolve(const std::string& address);
/// Whether only this machine can reach the address: all addresses of the host are loopback.
absl::StatusOr<bool> is_loopback(const std::string& address);

/// The text of an error of the operating system, e.g. "address in use".
std::string why_not(int error);

}  // namespace lucerna::rpc

#include "server/rpc/address.h"

#include <fmt/core.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cctype>
#include <cerrno>
#include <charconv>
#include <system_error>

#include "proto/common/status_macros.h"

namespace lucerna::rpc {
namespace {

std::size_t port_colon(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  // A colon within brackets belongs to an IPv6 address.
  if (colon == std::string::npos || address.find(']', colon) != std::string::npos) {
    return std::string::npos;
  }
  return colon;
}

std::string host_of(const std::string& address) {
  std::string host = address.substr(0, port_colon(address));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return host;
}

}  // namespace

absl::Status check_address(const std::string& address) {
  const std::size_t colon = port_colon(address);
  int port = -1;
  if (colon != std::string::npos && colon > 0) {
    const char* const end = address.data() + address.size();
    const auto [stopped, error] = std::from_chars(address.data() + colon + 1, end, port);
    if (error != std::errc() || stopped != end) port = -1;
  }
  if (port >= 0 && port <= 65535) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("listen = \"{}\", allowed: HOST:PORT with a port in [0, 65535]", address));
}

std::string with_port(const std::string& address, int port) {
  return fmt::format("{}:{}", address.substr(0, port_colon(address)), port);
}

absl::StatusOr<AddressList> resolve(const std::string& address) {
  const std::string port = address.substr(port_colon(address) + 1);
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string host = host_of(address);
  if (const int e = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); e != 0) {
    return absl::UnavailableError(fmt::format("cannot listen on {}: {}", address, gai_strerror(e)));
  }
  return AddressList(found);
}

absl::StatusOr<bool> is_loopback(const std::string& address) {
  LUCERNA_ASSIGN_OR_RETURN(const AddressList found, resolve(address));
  for (const addrinfo* a = found.get(); a != nullptr; a = a->ai_next) {
    if (a->ai_family == AF_INET) {
      const auto& v4 = *reinterpret_cast<const sockaddr_in*>(a->ai_addr);
      if ((ntohl(v4.sin_addr.s_addr) >> 24) != 127) return false;
    } else if (a->ai_family == AF_INET6) {
      const auto& v6 = *reinterpret_cast<const sockaddr_in6*>(a->ai_addr);
      if (!IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr)) return false;
    } else {
      return false;
    }
  }
  return true;
}

std::string why_not(int error) {
  if (error == EADDRINUSE) return "address in use";
  std::string why = std::generic_category().message(error);
  why[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(why[0])));
  return why;
}

}  // namespace lucerna::rpc

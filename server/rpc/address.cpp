#include "server/rpc/address.h"

#include <fmt/core.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <system_error>

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

std::string why_not_to_listen(const std::string& address) {
  const std::string port = address.substr(port_colon(address) + 1);
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int e = getaddrinfo(host_of(address).c_str(), port.c_str(), &hints, &found); e != 0) {
    return gai_strerror(e);
  }
  std::string why = "gRPC refused it";
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    const int fd = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
    const int yes = 1;  // as in gRPC
    if (fd >= 0) setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (fd < 0 || bind(fd, a->ai_addr, a->ai_addrlen) != 0 || listen(fd, 1) != 0) {
      why = std::generic_category().message(errno);
      why[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(why[0])));
      if (errno == EADDRINUSE) why = "address in use";
    }
    if (fd >= 0) close(fd);
  }
  freeaddrinfo(found);
  return why;
}

}  // namespace lucerna::rpc

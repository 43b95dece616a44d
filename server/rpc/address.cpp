#include "server/rpc/address.h"

#include <fmt/core.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cctype>
#include <cerrno>
#include <system_error>

#include "proto/common/host_port.h"
#include "proto/common/status_macros.h"

namespace lucerna::rpc {

absl::Status check_address(const std::string& setting, const std::string& address) {
  const absl::Status status = split_host_port(address, 0).status();
  if (status.ok()) return status;
  return absl::InvalidArgumentError(fmt::format("{} = {}", setting, std::string(status.message())));
}

std::string with_port(const std::string& address, int port) {
  return join_host_port({.host = split_host_port(address, 0)->host, .port = port});
}

absl::StatusOr<AddressList> resolve(const std::string& address) {
  LUCERNA_ASSIGN_OR_RETURN(const HostPort at, split_host_port(address, 0));
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = fmt::format("{}", at.port);
  if (const int e = getaddrinfo(at.host.c_str(), port.c_str(), &hints, &found); e != 0) {
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

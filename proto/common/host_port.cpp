#include "proto/common/host_port.h"

#include <arpa/inet.h>

#include <charconv>
#include <utility>

#include "absl/strings/str_cat.h"

namespace lucerna {
namespace {

constexpr int kHighestPort = 65535;

bool is_ipv6(const std::string& host) {
  in6_addr address;
  return inet_pton(AF_INET6, host.substr(0, host.find('%')).c_str(), &address) == 1;
}

/// The port; -1 for other text.
int read_port(const std::string& text) {
  unsigned port = 0;  // which has no sign
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && port <= kHighestPort ? static_cast<int>(port) : -1;
}

}  // namespace

absl::StatusOr<HostPort> split_host_port(const std::string& text, int lowest_port) {
  const auto wrong = [&](const auto&... why) {
    return absl::InvalidArgumentError(absl::StrCat("\"", text, "\": ", why...));
  };
  // A colon within brackets is a part of the host.
  const std::size_t bracket = text.rfind(']');
  const std::size_t colon = text.rfind(':');
  if (text.empty() || colon == 0) return wrong("no host, allowed: HOST:PORT");
  if (colon == std::string::npos || (bracket != std::string::npos && bracket > colon))
    return wrong("no port, allowed: HOST:PORT");
  std::string host = text.substr(0, colon);
  const bool brackets = host.size() > 1 && host.front() == '[' && host.back() == ']';
  if (brackets) host = host.substr(1, host.size() - 2);
  if (brackets ? !is_ipv6(host) : host.find_first_of(":[]/,\" \t") != std::string::npos)
    return wrong("host \"", text.substr(0, colon),
                 "\", allowed: a name, an IPv4 address, or an IPv6 address in brackets");
  const std::string digits = text.substr(colon + 1);
  const int port = read_port(digits);
  if (port < lowest_port)
    return wrong("port \"", digits, "\", allowed: ", lowest_port, " to ", kHighestPort);
  return HostPort{.host = std::move(host), .port = port};
}

std::string with_default_port(const std::string& text, int port) {
  const bool ipv6 = is_ipv6(text);
  const bool bare =
      text.starts_with('[') ? text.ends_with(']') : text.find(':') == std::string::npos;
  if (text.empty() || !(ipv6 || bare)) return text;
  return ipv6 ? absl::StrCat("[", text, "]:", port) : absl::StrCat(text, ":", port);
}

std::string join_host_port(const HostPort& address) {
  const bool colons = address.host.find(':') != std::string::npos;
  return colons ? absl::StrCat("[", address.host, "]:", address.port)
                : absl::StrCat(address.host, ":", address.port);
}

bool is_loopback(const HostPort& address) {
  in_addr v4;
  if (inet_pton(AF_INET, address.host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  return address.host == "localhost" || address.host == "::1";
}

}  // namespace lucerna

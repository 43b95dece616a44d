// Addresses "HOST:PORT" and "[IPV6]:PORT", as servers listen on them and clients connect to them.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace lucerna {

struct HostPort {
  std::string host;  ///< a name or a numeric address; IPv6 without brackets
  int port = 0;
};

/// Splits `text`.  Ports: `lowest_port` to 65535, as decimal digits.  An IPv6 address is in
/// brackets and may have a zone, such as "[fe80::1%eth0]:50051".  Nothing is looked up.
///
/// INVALID_ARGUMENT for other text.  The message begins with the text in quotes, and states what is
/// wrong in it and what is allowed.
absl::StatusOr<HostPort> split_host_port(const std::string& text, int lowest_port = 1);

/// `text` with a port: "localhost", "10.0.0.7", "::1" and "[::1]" get `port`.  An IPv6 address
/// without brackets gets brackets.  Other texts stay unchanged, so that split_host_port() can judge
/// them.
std::string with_default_port(const std::string& text, int port);

/// "HOST:PORT"; an IPv6 address gets brackets.
std::string join_host_port(const HostPort& address);

/// Whether only this machine reaches the host: "localhost", 127.0.0.0/8 or ::1.  Nothing is looked
/// up.
bool is_loopback(const HostPort& address);

}  // namespace lucerna

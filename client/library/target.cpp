#include "client/library/target.h"

#include <string_view>

#include "absl/strings/str_split.h"
#include "proto/common/status_macros.h"

namespace lucerna::client {

bool is_list(const std::string& target) {
  return target.starts_with("ipv4:") || target.starts_with("ipv6:");
}

absl::StatusOr<std::vector<HostPort>> servers_of(const std::string& target) {
  for (const char* scheme : {"unix:", "unix-abstract:", "vsock:", "xds:"}) {
    if (target.starts_with(scheme)) return std::vector<HostPort>();
  }
  std::vector<std::string> servers{target};
  if (is_list(target)) {
    servers = absl::StrSplit(target.substr(std::string_view("ipv4:").size()), ',');
  } else if (target.starts_with("dns:")) {
    // The authority of "dns://AUTHORITY/HOST:PORT" is a name server.
    servers = {target.substr(target.starts_with("dns://") ? target.find('/', 6) + 1 : 4)};
  }
  std::vector<HostPort> result;
  for (const std::string& server : servers) {
    LUCERNA_ASSIGN_OR_RETURN(result.emplace_back(), split_host_port(server));
  }
  return result;
}

}  // namespace lucerna::client

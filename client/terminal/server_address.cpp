#include "client/terminal/server_address.h"

#include <algorithm>
#include <string_view>

namespace lucerna::cli {
namespace {

constexpr char kDefaultPort[] = ":50051";
constexpr std::string_view kDns = "dns:///";

bool is_bare_ipv6(std::string_view host) {
  return std::count(host.begin(), host.end(), ':') > 1 &&
         host.find_first_not_of("0123456789abcdefABCDEF:.") == std::string_view::npos;
}

std::string host_with_port(const std::string& host) {
  if (host.empty()) return host;
  if (is_bare_ipv6(host)) return "[" + host + "]" + kDefaultPort;
  const bool has_port =
      host.starts_with('[') ? !host.ends_with(']') : host.find(':') != std::string::npos;
  return has_port ? host : host + kDefaultPort;
}

}  // namespace

std::string with_default_port(const std::string& servers) {
  if (servers.starts_with(kDns)) {
    return std::string(kDns) + host_with_port(servers.substr(kDns.size()));
  }
  for (const char* scheme :
       {"@", "slurm:", "unix:", "unix-abstract:", "vsock:", "ipv4:", "ipv6:"}) {
    if (servers.starts_with(scheme)) return servers;
  }
  if (servers.find("://") != std::string::npos) return servers;
  std::string result;
  for (std::size_t begin = 0; begin <= servers.size();) {
    const std::size_t end = std::min(servers.find(',', begin), servers.size());
    result += (begin == 0 ? "" : ",") + host_with_port(servers.substr(begin, end - begin));
    begin = end + 1;
  }
  return result;
}

}  // namespace lucerna::cli

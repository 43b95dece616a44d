#include "client/terminal/server_address.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
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

/// Whether gRPC resolves the text by a scheme of its own, or Lucerna by a file or Slurm.
bool has_scheme(const std::string& servers) {
  for (const char* scheme :
       {"@", "slurm:", "unix:", "unix-abstract:", "vsock:", "ipv4:", "ipv6:"}) {
    if (servers.starts_with(scheme)) return true;
  }
  return servers.find("://") != std::string::npos;
}

/// Empty for a host with a port.  gRPC would take port 65537 for port 1.
std::string error_of(std::string_view server) {
  const std::size_t colon = server.rfind(':');
  if (colon == 0 || server.empty())
    return fmt::format("server \"{}\": no host, allowed: HOST or HOST:PORT", server);
  const std::string_view text = colon < server.size() ? server.substr(colon + 1) : "";
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port < 1 || port > 65535)
    return fmt::format("server \"{}\": port \"{}\", allowed: 1 to 65535", server, text);
  return {};
}

}  // namespace

std::string with_default_port(const std::string& servers) {
  if (servers.starts_with(kDns)) {
    return std::string(kDns) + host_with_port(servers.substr(kDns.size()));
  }
  if (has_scheme(servers)) return servers;
  std::string result;
  for (std::size_t begin = 0; begin <= servers.size();) {
    const std::size_t end = std::min(servers.find(',', begin), servers.size());
    result += (begin == 0 ? "" : ",") + host_with_port(servers.substr(begin, end - begin));
    begin = end + 1;
  }
  return result;
}

CLI::Validator server_addresses() {
  return {
      [](std::string& servers) -> std::string {
        servers = with_default_port(servers);
        const bool by_dns = servers.starts_with(kDns);
        if (has_scheme(servers) && !by_dns) return {};
        const std::string_view list = std::string_view(servers).substr(by_dns ? kDns.size() : 0);
        for (std::size_t begin = 0; begin <= list.size();) {
          const std::size_t end = std::min(list.find(',', begin), list.size());
          if (const std::string error = error_of(list.substr(begin, end - begin)); !error.empty())
            return error;
          begin = end + 1;
        }
        return {};
      },
      ""};
}

}  // namespace lucerna::cli

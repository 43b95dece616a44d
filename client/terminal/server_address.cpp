#include "client/terminal/server_address.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "client/terminal/error.h"

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

void SecurityOptions::add(CLI::App& app) {
  app.add_flag("--tls", security_.tls, "Use TLS; any other option of TLS does so too")
      ->envname("LUCERNA_TLS");
  const auto file = [&](const char* name, std::string& value, const char* variable,
                        const char* help) {
    app.add_option(name, value, help)->type_name("FILE")->envname(variable);
  };
  file(
      "--tls-ca", security_.ca_file, "LUCERNA_TLS_CA",
      "Authorities that may sign the server's certificate, in PEM; default: those of this machine");
  file("--tls-cert", security_.certificate_file, "LUCERNA_TLS_CERT",
       "Certificate of this client, in PEM");
  file("--tls-key", security_.key_file, "LUCERNA_TLS_KEY", "Private key of --tls-cert, in PEM");
  app.add_option("--tls-name", security_.name,
                 "Name that the server's certificate must have; default: the host of --server")
      ->type_name("HOST")
      ->envname("LUCERNA_TLS_NAME");
  file("--token-file", token_file_, "LUCERNA_TOKEN_FILE",
       "File with the token of the caller; default: the variable LUCERNA_TOKEN");
}

client::Security SecurityOptions::security() const {
  client::Security security = security_;
  security.tls = security.tls || !security.ca_file.empty() || !security.certificate_file.empty() ||
                 !security.key_file.empty() || !security.name.empty();
  if (!token_file_.empty()) {
    std::ifstream file(token_file_);
    if (!std::getline(file, security.token) || security.token.empty()) {
      wrong_use(fmt::format("--token-file: {} has no token in its first line", token_file_));
    }
  } else if (const char* token = std::getenv("LUCERNA_TOKEN"); token != nullptr) {
    security.token = token;
  }
  const bool printable = std::all_of(security.token.begin(), security.token.end(),
                                     [](unsigned char c) { return c > ' ' && c < 0x7F; });
  if (!printable) wrong_use("the token has a character that is not allowed: only visible ASCII");
  return security;
}

}  // namespace lucerna::cli

#include "client/terminal/server_address.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include "client/terminal/error.h"
#include "lucerna/client/server_list.h"
#include "proto/common/host_port.h"

namespace lucerna::cli {
namespace {

constexpr int kDefaultPort = 50051;
constexpr std::string_view kDns = "dns:///";

/// Whether gRPC resolves the text by a scheme of its own, or Lucerna by a file or Slurm.
bool has_scheme(const std::string& servers) {
  for (const char* scheme :
       {"@", "slurm:", "unix:", "unix-abstract:", "vsock:", "ipv4:", "ipv6:"}) {
    if (servers.starts_with(scheme)) return true;
  }
  return servers.find("://") != std::string::npos;
}

}  // namespace

std::string with_default_port(const std::string& servers) {
  if (servers.starts_with(kDns)) {
    return std::string(kDns) +
           lucerna::with_default_port(servers.substr(kDns.size()), kDefaultPort);
  }
  if (has_scheme(servers)) return servers;
  std::string result;
  for (std::size_t begin = 0; begin <= servers.size();) {
    const std::size_t end = std::min(servers.find(',', begin), servers.size());
    result += (begin == 0 ? "" : ",") +
              lucerna::with_default_port(servers.substr(begin, end - begin), kDefaultPort);
    begin = end + 1;
  }
  return result;
}

CLI::Validator server_addresses() {
  return {[](std::string& servers) -> std::string {
            servers = with_default_port(servers);
            const absl::Status status = client::server_list(servers).status();
            return std::string(status.message());
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

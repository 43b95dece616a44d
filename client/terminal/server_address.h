// Addresses of servers as people type them, and the options of TLS and tokens.
#pragma once

#include <string>

#include "lucerna/client/security.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace lucerna::cli {

/// `servers` with ":50051" after each host that has no port: "localhost", "10.0.0.7", "::1",
/// "[::1]", "a,b:50052", "dns:///name".  An IPv6 address without brackets gets brackets.  Other
/// texts stay unchanged: "@FILE", "slurm:PORT", "unix:PATH" and other schemes of gRPC.
std::string with_default_port(const std::string& servers);

/// Adds default ports to the text.  The message names what client::server_list() refuses, such as a
/// port outside of 1 to 65535.
CLI::Validator server_addresses();

/// --tls, --tls-ca, --tls-cert, --tls-key, --tls-name and --token-file, with their environment
/// variables.
class SecurityOptions {
 public:
  void add(CLI::App& app);
  /// Reads the token.  Ends the program if its file cannot be read.
  client::Security security() const;

 private:
  client::Security security_;
  std::string token_file_;
};

}  // namespace lucerna::cli

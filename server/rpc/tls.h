// TLS for the server, with certificates that can be replaced while it runs.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>
#include <vector>

#include "server/rpc/connection_options.h"

namespace lucerna::rpc {

/// One sentence for each certificate of the files that has expired or is not valid yet.  Clients
/// refuse a server with such a certificate.  None if the files cannot be read.
std::vector<std::string> certificate_warnings(const TlsFiles& files);

/// Credentials of the server.  Thread-safe.
class Tls {
 public:
  /// Reads and checks the files.  INVALID_ARGUMENT if a file cannot be read or parsed, if the key
  /// does not belong to the certificate, or if only one of certificate and key is given.
  static absl::StatusOr<std::shared_ptr<Tls>> open(const TlsFiles& files);
  virtual ~Tls() = default;

  /// New connections use these files; connections that exist continue.  After an error, the files
  /// of before stay in use.
  virtual absl::Status reload(const TlsFiles& files) = 0;
  /// Credentials that keep this object alive.
  virtual std::shared_ptr<grpc::ServerCredentials> credentials() = 0;
};

}  // namespace lucerna::rpc

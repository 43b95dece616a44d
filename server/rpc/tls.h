// TLS for the server, with certificates that can be replaced while it runs.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpc/grpc_security.h>
#include <grpcpp/security/server_credentials.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/rpc/connection_options.h"

namespace lucerna::rpc {

/// One sentence for each certificate of the files that has expired or is not valid yet.  Clients
/// refuse a server with such a certificate.  None if the files cannot be read.
std::vector<std::string> certificate_warnings(const TlsFiles& files);

/// Credentials of the server.  Thread-safe.
class Tls final : public std::enable_shared_from_this<Tls> {
 public:
  /// Reads and checks the files.  INVALID_ARGUMENT if a file cannot be read or parsed, if the key
  /// does not belong to the certificate, or if only one of certificate and key is given.
  static absl::StatusOr<std::shared_ptr<Tls>> open(const TlsFiles& files);

  /// New connections use these files; connections that exist continue.  After an error, the files
  /// of before stay in use.
  absl::Status reload(const TlsFiles& files);
  /// Credentials that keep this object alive.
  std::shared_ptr<grpc::ServerCredentials> credentials();

 private:
  /// The texts of the files.
  struct Texts {
    std::string certificate, key, client_ca;
  };
  class Credentials;

  Tls(const TlsFiles& files, Texts texts)
      : texts_(std::move(texts)), needs_clients_(!files.client_ca.empty()) {}
  static absl::StatusOr<Texts> read(const TlsFiles& files);
  /// The certificates, unless their version is `known`, which becomes theirs.
  grpc_ssl_certificate_config_reload_status fetch(std::uint64_t& known,
                                                  grpc_ssl_server_certificate_config** config);

  std::mutex mutex_;
  Texts texts_;                // guarded by mutex_
  std::uint64_t version_ = 1;  // guarded by mutex_; of texts_
  const bool needs_clients_;
};

}  // namespace lucerna::rpc

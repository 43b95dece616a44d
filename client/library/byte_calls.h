// Calls whose requests and answers are bytes.
//
// A load generator serialises its requests once, sends them many times, and counts bytes.  This
// header is not installed.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/library/client.h"

namespace lucerna::client {

/// A connection of its own to a server.  It has no retries: each call is one attempt.
///
/// Thread safety: as Client.
class ByteCalls {
 public:
  /// Creates the connection; nothing is sent yet.  Errors as Client::connect; `options.retry` has
  /// no effect.
  static absl::StatusOr<ByteCalls> connect(ConnectOptions options);

  /// The callback of a call.  It runs once, in a thread of gRPC, and must return soon.  It must not
  /// destroy a ByteCalls.
  using Done = std::function<void(absl::StatusOr<std::string>)>;
  /// Begins a unary call.  `method` is a full name such as
  /// "/lucerna.v1.AdminService/GetServerInfo".  `request` is a serialised message; the result is
  /// the serialised response.
  void call(const std::string& method, const std::string& request, const CallOptions& options,
            Done done) const;

 private:
  class Connection;
  explicit ByteCalls(std::shared_ptr<const Connection> connection);

  std::shared_ptr<const Connection> connection_;
};

}  // namespace lucerna::client

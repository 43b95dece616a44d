// TLS and tokens of a connection, and why a connection fails.
#pragma once

#include <cstdint>
#include <string>

namespace lucerna::client {

struct Security {
  /// Encrypts the connection.
  bool tls = false;
  /// PEM file with the authorities that may sign the server's certificate; empty: those of this
  /// machine.
  std::string ca_file{};
  /// PEM files of a client certificate and its private key; empty: none.
  std::string certificate_file{}, key_file{};
  /// The name that the server's certificate must have; empty: the host of the target.
  std::string name{};
  /// Sent with each call; empty: none.  Without TLS, only a server on this machine gets it.
  std::string token{};
};

/// The reason if nothing listens at the address.
inline constexpr char kNoServer[] = "no server listens there";

/// The step of a connection that fails.
enum class ConnectStep : std::uint8_t {
  kNone,     ///< all steps succeed, or the target is no HOST:PORT
  kAddress,  ///< the name has no address, or nothing listens there
  kTls,      ///< the handshake, or one side does not use TLS
};

struct Obstacle {
  ConnectStep step = ConnectStep::kNone;
  std::string why{};  ///< empty for kNone
};

/// The first step that fails on the way to `target`, as in why_unreachable().
Obstacle find_obstacle(const std::string& target, const Security& security);

/// The reason why no connection to `target` (as in ConnectOptions) comes about, e.g. "the server's
/// certificate has expired".  gRPC does not report it.  Makes connections of its own, for at most
/// some seconds.  Empty if a connection comes about, or for a target that is no HOST:PORT.
std::string why_unreachable(const std::string& target, const Security& security);

}  // namespace lucerna::client

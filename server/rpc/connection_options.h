// Options of connections: who may connect, and how.
#pragma once

#include <cstdint>
#include <string>

namespace lucerna::rpc {

/// PEM files.
struct TlsFiles {
  std::string certificate;  ///< the server's chain, its own certificate first; empty: no TLS
  std::string key;          ///< its private key
  std::string client_ca;    ///< clients need a certificate of this authority; empty: none needed

  bool given() const { return !certificate.empty() || !key.empty() || !client_ca.empty(); }
};

struct ConnectionLimits {
  std::uint32_t connections = 4096;       ///< open at once
  std::uint32_t peer_connections = 1024;  ///< open at once from one address
};

struct ConnectionOptions {
  TlsFiles tls;
  /// Allows an address that other machines reach, without TLS.
  bool insecure = false;
  std::string token_file;  ///< see server/rpc/token_file.h; empty: every caller may do everything
  ConnectionLimits limits;
  std::uint32_t streams = 1000;        ///< calls at once on one connection
  std::uint32_t idle_s = 1800;         ///< a connection without calls is closed; 0: never
  std::uint32_t handshake_s = 20;      ///< for TLS and the start of HTTP/2
  std::uint32_t ping_s = 60;           ///< pings to a silent client, to find that it is gone
  std::uint32_t least_ping_gap_s = 5;  ///< a client that pings more often is disconnected
};

}  // namespace lucerna::rpc

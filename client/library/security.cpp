#include "client/library/security.h"

#include <netdb.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/library/target.h"

namespace lucerna::client {
namespace {

constexpr timeval kPatience{3, 0};

struct FreeContext {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
};
struct FreeSsl {
  void operator()(SSL* ssl) const { SSL_free(ssl); }
};
struct Close {
  ~Close() {
    if (fd >= 0) close(fd);
  }
  int fd;
};

/// A connected socket; -1 with the reason in `why`.
int connect_to(const HostPort& to, std::string& why) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(to.port);
  if (const int e = getaddrinfo(to.host.c_str(), port.c_str(), &hints, &found); e != 0) {
    why = absl::StrCat("the name ", to.host, " has no address: ", gai_strerror(e));
    return -1;
  }
  int connected = -1;
  for (const addrinfo* a = found; a != nullptr && connected < 0; a = a->ai_next) {
    const int fd = socket(a->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) continue;
    // connect() observes the time of sending.
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
    if (connect(fd, a->ai_addr, a->ai_addrlen) == 0) {
      connected = fd;
      why.clear();
    } else {
      why = errno == ECONNREFUSED  ? kNoServer
            : errno == EINPROGRESS ? "the machine does not answer"
                                   : std::strerror(errno);
      close(fd);
    }
  }
  freeaddrinfo(found);
  return connected;
}

std::string verification(long result, const std::string& name, const Security& security) {
  const std::string roots =
      security.ca_file.empty() ? "the authorities of this machine" : security.ca_file;
  switch (result) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return "the server's certificate has expired";
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return "the server's certificate is not valid yet";
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return absl::StrCat("the server's certificate is not for the name ", name);
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
      return absl::StrCat("the server's certificate is not signed by an authority of ", roots);
    default:
      return absl::StrCat("the server's certificate is not accepted: ",
                          X509_verify_cert_error_string(result));
  }
}

/// What the server answered to the handshake, as its alert states.
std::string alert(unsigned long error, const Security& security) {
  switch (ERR_GET_REASON(error)) {
    case SSL_R_TLSV13_ALERT_CERTIFICATE_REQUIRED:
      return "the server needs a client certificate";
    case SSL_R_SSLV3_ALERT_HANDSHAKE_FAILURE:
      return security.certificate_file.empty() ? "the server needs a client certificate"
                                               : "the server refuses the handshake";
    case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
      return "the client certificate has expired";
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA:
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
    case SSL_R_TLSV1_ALERT_DECRYPT_ERROR:
      return "the server does not accept the client certificate";
    case SSL_R_WRONG_VERSION_NUMBER:
    case SSL_R_PACKET_LENGTH_TOO_LONG:
    case SSL_R_HTTP_REQUEST:
      return "the server does not use TLS on this port";
    default:
      return {};
  }
}

/// Notes that the server asks for a certificate of the client.
int note_request(SSL* ssl, X509**, EVP_PKEY**) {
  *static_cast<bool*>(SSL_get_app_data(ssl)) = true;
  return 0;  // none is sent
}

bool has_expired(const X509* certificate) {
  return certificate != nullptr && X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0;
}

struct Probe {
  bool speaks_tls = false;
  std::string why;
};

Probe probe_tls(int fd, const std::string& host, const Security& security) {
  ERR_clear_error();
  const std::unique_ptr<SSL_CTX, FreeContext> context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  if (security.ca_file.empty()) {
    SSL_CTX_set_default_verify_paths(context.get());
  } else {
    SSL_CTX_load_verify_locations(context.get(), security.ca_file.c_str(), nullptr);
  }
  if (!security.certificate_file.empty()) {
    SSL_CTX_use_certificate_chain_file(context.get(), security.certificate_file.c_str());
    SSL_CTX_use_PrivateKey_file(context.get(), security.key_file.c_str(), SSL_FILETYPE_PEM);
  }
  bool asked = false;
  SSL_CTX_set_client_cert_cb(context.get(), note_request);
  ERR_clear_error();
  const std::unique_ptr<SSL, FreeSsl> ssl(SSL_new(context.get()));
  SSL_set_app_data(ssl.get(), &asked);
  const std::string name = security.name.empty() ? host : security.name;
  X509_VERIFY_PARAM* parameters = SSL_get0_param(ssl.get());
  if (X509_VERIFY_PARAM_set1_ip_asc(parameters, name.c_str()) != 1) {
    X509_VERIFY_PARAM_set1_host(parameters, name.c_str(), name.size());
    SSL_set_tlsext_host_name(ssl.get(), name.c_str());
  }
  // The handshake goes on after a wrong certificate, so that all reasons can be told apart.
  SSL_set_verify(ssl.get(), SSL_VERIFY_NONE, nullptr);
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_set_alpn_protos(ssl.get(), kHttp2, sizeof kHttp2);
  SSL_set_fd(ssl.get(), fd);
  Probe probe;
  ERR_clear_error();
  const bool done = SSL_connect(ssl.get()) == 1;
  probe.speaks_tls = done || SSL_get0_peer_certificate(ssl.get()) != nullptr;
  if (probe.speaks_tls) {
    if (const long result = SSL_get_verify_result(ssl.get()); result != X509_V_OK) {
      probe.why = verification(result, name, security);
      return probe;
    }
  }
  // With TLS 1.3 the server judges the client's certificate after the client's handshake.
  char byte = 0;
  if (done && SSL_read(ssl.get(), &byte, 1) > 0) return probe;
  probe.why = alert(ERR_peek_error(), security);
  ERR_clear_error();
  if (!probe.why.empty() || !probe.speaks_tls) return probe;
  // gRPC's servers close the connection without an alert.
  if (has_expired(SSL_get_certificate(ssl.get()))) {
    probe.why = "the client certificate has expired";
  } else if (SSL_get_certificate(ssl.get()) != nullptr) {
    probe.why = "the server does not accept the client certificate";
  } else if (asked) {
    probe.why = "the server needs a client certificate";
  }
  return probe;
}

}  // namespace

Obstacle find_obstacle(const std::string& target, const Security& security) {
  const auto servers = servers_of(target);
  if (!servers.ok() || servers->empty()) return {};
  const HostPort& to = servers->front();
  std::string why;
  const Close socket{connect_to(to, why)};
  if (socket.fd < 0) return {ConnectStep::kAddress, why};
  Probe probe = probe_tls(socket.fd, to.host, security);
  if (!security.tls) {
    probe.why = probe.speaks_tls ? "the server uses TLS, and the client does not" : "";
  }
  if (probe.why.empty()) return {};
  return {ConnectStep::kTls, std::move(probe.why)};
}

std::string why_unreachable(const std::string& target, const Security& security) {
  return find_obstacle(target, security).why;
}

}  // namespace lucerna::client

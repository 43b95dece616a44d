#include "server/rpc/tls.h"

#include <fmt/chrono.h>
#include <fmt/core.h>
#include <grpc/grpc.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <ctime>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/runtime/text_file.h"

namespace lucerna::rpc {
namespace {

template <auto free>
struct Free {
  void operator()(auto* object) const { free(object); }
};
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using PrivateKey = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Bio = std::unique_ptr<BIO, Free<BIO_free>>;

absl::StatusOr<std::string> read_setting(const char* setting, const std::string& path) {
  absl::StatusOr<std::string> text = read_text_file(path);
  if (text.ok()) return text;
  return absl::InvalidArgumentError(
      fmt::format("{}: {} {}", setting, path, std::string(text.status().message())));
}

/// Calls `f` with each certificate in the text.
template <typename F>
void for_each_certificate(const std::string& text, const F& f) {
  const Bio bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
  for (;;) {
    Certificate next(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
    if (next == nullptr) break;
    f(std::move(next));
  }
  ERR_clear_error();
}

/// The number of certificates in the text.  The first is stored in `first`.
int certificates(const std::string& text, Certificate* first) {
  int count = 0;
  for_each_certificate(text, [&](Certificate next) {
    if (count++ == 0 && first != nullptr) *first = std::move(next);
  });
  return count;
}

/// "2026-11-28 07:30:00 UTC".
std::string describe(const ASN1_TIME* time) {
  std::tm utc{};
  ASN1_TIME_to_tm(time, &utc);
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", utc);
}

/// Adds a warning for each certificate of the file that is not valid now.
void add_warnings(const char* setting, const std::string& path,
                  std::vector<std::string>& warnings) {
  if (path.empty()) return;
  const absl::StatusOr<std::string> text = read_text_file(path);
  if (!text.ok()) return;
  for_each_certificate(*text, [&](const Certificate& certificate) {
    const ASN1_TIME* const from = X509_get0_notBefore(certificate.get());
    const ASN1_TIME* const until = X509_get0_notAfter(certificate.get());
    // These return 0 for a time that cannot be read.
    if (X509_cmp_current_time(until) <= 0) {
      warnings.push_back(
          fmt::format("{}: a certificate of {} expired on {}", setting, path, describe(until)));
    } else if (X509_cmp_current_time(from) >= 0) {
      warnings.push_back(fmt::format("{}: a certificate of {} is not valid before {}", setting,
                                     path, describe(from)));
    }
  });
}

/// A key with a password would otherwise ask for it on the terminal.
int no_password(char*, int, int, void*) { return -1; }

}  // namespace

std::vector<std::string> certificate_warnings(const TlsFiles& files) {
  std::vector<std::string> warnings;
  add_warnings("tls-cert", files.certificate, warnings);
  add_warnings("tls-client-ca", files.client_ca, warnings);
  return warnings;
}

absl::StatusOr<Tls::Texts> Tls::read(const TlsFiles& files) {
  if (files.certificate.empty() || files.key.empty()) {
    return absl::InvalidArgumentError("tls-cert and tls-key, allowed: both or neither");
  }
  Texts texts;
  LUCERNA_ASSIGN_OR_RETURN(texts.certificate, read_setting("tls-cert", files.certificate));
  LUCERNA_ASSIGN_OR_RETURN(texts.key, read_setting("tls-key", files.key));
  Certificate own;
  if (certificates(texts.certificate, &own) == 0) {
    return absl::InvalidArgumentError(
        fmt::format("tls-cert: {} has no certificate in PEM", files.certificate));
  }
  const Bio bio(BIO_new_mem_buf(texts.key.data(), static_cast<int>(texts.key.size())));
  const PrivateKey key(PEM_read_bio_PrivateKey(bio.get(), nullptr, no_password, nullptr));
  ERR_clear_error();
  if (key == nullptr) {
    return absl::InvalidArgumentError(
        fmt::format("tls-key: {} has no private key in PEM without a password", files.key));
  }
  if (X509_check_private_key(own.get(), key.get()) != 1) {
    ERR_clear_error();
    return absl::InvalidArgumentError(fmt::format(
        "tls-key: {} is not the key of the certificate {}", files.key, files.certificate));
  }
  if (!files.client_ca.empty()) {
    LUCERNA_ASSIGN_OR_RETURN(texts.client_ca, read_setting("tls-client-ca", files.client_ca));
    if (certificates(texts.client_ca, nullptr) == 0) {
      return absl::InvalidArgumentError(
          fmt::format("tls-client-ca: {} has no certificate in PEM", files.client_ca));
    }
  }
  return texts;
}

absl::StatusOr<std::shared_ptr<Tls>> Tls::open(const TlsFiles& files) {
  LUCERNA_ASSIGN_OR_RETURN(Texts texts, read(files));
  return std::shared_ptr<Tls>(new Tls(files, std::move(texts)));
}

absl::Status Tls::reload(const TlsFiles& files) {
  if (needs_clients_ == files.client_ca.empty())
    return absl::InvalidArgumentError(
        "tls-client-ca: whether clients need a certificate changes only at a restart");
  LUCERNA_ASSIGN_OR_RETURN(Texts texts, read(files));
  const std::lock_guard lock(mutex_);
  texts_ = std::move(texts);
  ++version_;
  return absl::OkStatus();
}

grpc_ssl_certificate_config_reload_status Tls::fetch(std::uint64_t& known,
                                                     grpc_ssl_server_certificate_config** config) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(known, version_) == version_)
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  const grpc_ssl_pem_key_cert_pair pair{texts_.key.c_str(), texts_.certificate.c_str()};
  // gRPC wants roots even if it asks clients for no certificate.  Then it does not use them.
  const std::string& roots = needs_clients_ ? texts_.client_ca : texts_.certificate;
  *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

/// gRPC's C++ interface has no credentials that reload and keep the certificates of before if the
/// new ones are wrong.  Its C interface has.
class Tls::Credentials final : public grpc::ServerCredentials {
 public:
  explicit Credentials(std::shared_ptr<Tls> tls) : tls_(std::move(tls)) {
    const auto request = tls_->needs_clients_
                             ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                             : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE;
    credentials_ = grpc_ssl_server_credentials_create_with_options(
        grpc_ssl_server_credentials_create_options_using_config_fetcher(request,
                                                                        &Credentials::fetch, this));
  }
  ~Credentials() override { grpc_server_credentials_release(credentials_); }
  Credentials(const Credentials&) = delete;
  Credentials& operator=(const Credentials&) = delete;

  // Tokens are checked by Access, which works without TLS too.
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  /// gRPC calls this before each handshake.
  static grpc_ssl_certificate_config_reload_status fetch(
      void* self, grpc_ssl_server_certificate_config** config) {
    auto& credentials = *static_cast<Credentials*>(self);
    return credentials.tls_->fetch(credentials.known_, config);
  }
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  std::shared_ptr<Tls> tls_;
  std::uint64_t known_ = 0;  // the version of the certificates that gRPC has
  grpc_server_credentials* credentials_;
};

std::shared_ptr<grpc::ServerCredentials> Tls::credentials() {
  return std::make_shared<Credentials>(shared_from_this());
}

}  // namespace lucerna::rpc

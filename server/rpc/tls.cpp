#include "server/rpc/tls.h"

#include <fmt/chrono.h>
#include <fmt/core.h>
#include <grpc/grpc.h>
#include <grpc/grpc_security.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <ctime>
#include <mutex>
#include <utility>

#include "proto/common/status_macros.h"
#include "server/runtime/text_file.h"

namespace lucerna::rpc {
namespace {

template <class T, void (*free)(T*)>
struct Free {
  void operator()(T* object) const { free(object); }
};
using Certificate = std::unique_ptr<X509, Free<X509, X509_free>>;
using PrivateKey = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY, EVP_PKEY_free>>;
struct FreeBio {
  void operator()(BIO* bio) const { BIO_free(bio); }
};
using Bio = std::unique_ptr<BIO, FreeBio>;

/// The texts of the files.
struct Material {
  std::string certificate, key, client_ca;
};

absl::StatusOr<std::string> read(const char* setting, const std::string& path) {
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

absl::StatusOr<Material> read_material(const TlsFiles& files) {
  if (files.certificate.empty() || files.key.empty()) {
    return absl::InvalidArgumentError("tls-cert and tls-key, allowed: both or neither");
  }
  Material material;
  LUCERNA_ASSIGN_OR_RETURN(material.certificate, read("tls-cert", files.certificate));
  LUCERNA_ASSIGN_OR_RETURN(material.key, read("tls-key", files.key));
  Certificate own;
  if (certificates(material.certificate, &own) == 0) {
    return absl::InvalidArgumentError(
        fmt::format("tls-cert: {} has no certificate in PEM", files.certificate));
  }
  const Bio bio(BIO_new_mem_buf(material.key.data(), static_cast<int>(material.key.size())));
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
    LUCERNA_ASSIGN_OR_RETURN(material.client_ca, read("tls-client-ca", files.client_ca));
    if (certificates(material.client_ca, nullptr) == 0) {
      return absl::InvalidArgumentError(
          fmt::format("tls-client-ca: {} has no certificate in PEM", files.client_ca));
    }
  }
  return material;
}

class ReloadingTls final : public Tls, public std::enable_shared_from_this<ReloadingTls> {
 public:
  ReloadingTls(const TlsFiles& files, Material material)
      : material_(std::move(material)), needs_clients_(!files.client_ca.empty()) {}

  absl::Status reload(const TlsFiles& files) override {
    if (needs_clients_ == files.client_ca.empty()) {
      return absl::InvalidArgumentError(
          "tls-client-ca: whether clients need a certificate changes only at a restart");
    }
    LUCERNA_ASSIGN_OR_RETURN(Material material, read_material(files));
    const std::lock_guard lock(mutex_);
    material_ = std::move(material);
    ++version_;
    return absl::OkStatus();
  }

  std::shared_ptr<grpc::ServerCredentials> credentials() override;

  bool needs_clients() const { return needs_clients_; }

  /// The certificates, unless their version is `known`, which becomes theirs.
  grpc_ssl_certificate_config_reload_status fetch(std::uint64_t& known,
                                                  grpc_ssl_server_certificate_config** config) {
    const std::lock_guard lock(mutex_);
    if (std::exchange(known, version_) == version_)
      return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    const grpc_ssl_pem_key_cert_pair pair{material_.key.c_str(), material_.certificate.c_str()};
    // gRPC wants roots even if it asks clients for no certificate.  Then it does not use them.
    const std::string& roots = needs_clients_ ? material_.client_ca : material_.certificate;
    *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

 private:
  std::mutex mutex_;
  Material material_;          // guarded by mutex_
  std::uint64_t version_ = 1;  // guarded by mutex_; of material_
  const bool needs_clients_;
};

/// gRPC's C++ interface has no credentials that reload and keep the certificates of before if the
/// new ones are wrong.  Its C interface has.
class Credentials final : public grpc::ServerCredentials {
 public:
  explicit Credentials(std::shared_ptr<ReloadingTls> tls) : tls_(std::move(tls)) {
    const auto request = tls_->needs_clients()
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

  std::shared_ptr<ReloadingTls> tls_;
  std::uint64_t known_ = 0;  // the version of the certificates that gRPC has
  grpc_server_credentials* credentials_;
};

std::shared_ptr<grpc::ServerCredentials> ReloadingTls::credentials() {
  return std::make_shared<Credentials>(shared_from_this());
}

}  // namespace

std::vector<std::string> certificate_warnings(const TlsFiles& files) {
  std::vector<std::string> warnings;
  add_warnings("tls-cert", files.certificate, warnings);
  add_warnings("tls-client-ca", files.client_ca, warnings);
  return warnings;
}

absl::StatusOr<std::shared_ptr<Tls>> Tls::open(const TlsFiles& files) {
  LUCERNA_ASSIGN_OR_RETURN(Material material, read_material(files));
  return std::make_shared<ReloadingTls>(files, std::move(material));
}

}  // namespace lucerna::rpc

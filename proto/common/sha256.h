// SHA-256 of data in parts.
#pragma once

#include <memory>
#include <string>
#include <string_view>

// OpenSSL's EVP_MD_CTX.
struct evp_md_ctx_st;

namespace lucerna {

inline constexpr std::size_t kSha256Bytes = 32;

class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// The state of the same bytes.
  Sha256 copy() const;
  /// The digest, 32 bytes.  Do not call add() after it.
  std::string finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

std::string sha256(std::string_view bytes);

/// Two lower-case digits for each byte.
std::string hexadecimal(std::string_view bytes);

}  // namespace lucerna

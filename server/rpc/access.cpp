#include "server/rpc/access.h"

#include <fmt/format.h>
#include <openssl/crypto.h>

#include <utility>

#include "proto/common/sha256.h"

namespace lucerna::access {
namespace {

constexpr std::string_view kBearer = "Bearer ";

/// Takes the same time for every token, known or not.
const Token* find(const std::vector<Token>& tokens, const std::string& digest) {
  const Token* found = nullptr;
  for (const Token& token : tokens) {
    if (CRYPTO_memcmp(token.sha256.data(), digest.data(), kSha256Bytes) == 0) found = &token;
  }
  return found;
}

}  // namespace

void Access::set_tokens(std::vector<Token> tokens) {
  auto known = std::make_shared<const std::vector<Token>>(std::move(tokens));
  const std::lock_guard lock(mutex_);
  tokens_ = std::move(known);
}

bool Access::open() {
  const std::lock_guard lock(mutex_);
  return tokens_ == nullptr;
}

absl::StatusOr<Admission> Access::admit(Call call, std::string_view authorization,
                                        std::string* name_of_token) {
  std::shared_ptr<const std::vector<Token>> known;
  {
    const std::lock_guard lock(mutex_);
    known = tokens_;
  }
  if (known == nullptr) return Admission{};
  if (!authorization.starts_with(kBearer)) {
    return absl::UnauthenticatedError(
        "the call has no token, and this server needs one: authorization: Bearer TOKEN");
  }
  const Token* token = find(*known, sha256(std::string(authorization.substr(kBearer.size()))));
  if (token == nullptr) {
    return absl::UnauthenticatedError(
        "the server does not know this token; it is wrong or was revoked");
  }
  if (name_of_token != nullptr) *name_of_token = token->name;
  const Role needed = role_of(call);
  if (!token->roles.contains(needed)) {
    const std::string_view name = monitor::name_of(call);
    std::vector<std::string_view> roles;
    for (const Role role : token->roles) roles.emplace_back(name_of(role));
    return absl::PermissionDeniedError(fmt::format(
        "{} needs the role {}, and the token of \"{}\" has only: {}",
        name.substr(name.find('/') + 1), name_of(needed), token->name, fmt::join(roles, ", ")));
  }
  Admission admission{{token->name, token->roles.contains(Role::kAdmin), token->quota}, {}};
  {
    const std::lock_guard lock(mutex_);
    admission.in_flight.reset(&usages_[token->name]);
  }
  const std::uint64_t before = admission.in_flight->in_flight.fetch_add(1);
  if (token->quota.requests > 0 && before >= token->quota.requests) {
    return absl::ResourceExhaustedError(
        fmt::format("{} requests of \"{}\" are in flight, allowed: {}", before, token->name,
                    token->quota.requests));
  }
  return admission;
}

}  // namespace lucerna::access

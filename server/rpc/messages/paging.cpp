#include "server/rpc/messages/paging.h"

#include <absl/strings/escaping.h>
#include <fmt/core.h>

#include <charconv>

#include "proto/common/sha256.h"
#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {

// A token of another list passes by chance once in 2^64.
constexpr std::size_t kSealBytes = 8;

absl::Status bad_token(const std::string& token) {
  return bad_field("page_token", fmt::format("\"{}\"", token),
                   "empty, or next_page_token of the previous answer to the same request");
}

std::string seal(const std::string& list, const std::string& position) {
  return sha256(fmt::format("{}:{}{}", list.size(), list, position)).substr(0, kSealBytes);
}

}  // namespace

absl::StatusOr<std::size_t> check_page_size(std::uint32_t page_size, std::uint32_t most) {
  if (page_size > most) {
    return bad_field("page_size", page_size, "[0, {}]", most);
  }
  return page_size == 0 ? most : page_size;
}

std::string page_token(const std::string& list, const std::string& position) {
  return absl::WebSafeBase64Escape(seal(list, position) + position);
}

absl::StatusOr<std::string> page_position(const std::string& list, const std::string& token) {
  if (token.empty()) return std::string();
  std::string text;
  if (!absl::WebSafeBase64Unescape(token, &text) || text.size() < kSealBytes) {
    return bad_token(token);
  }
  std::string position = text.substr(kSealBytes);
  if (!text.starts_with(seal(list, position))) return bad_token(token);
  return position;
}

std::string page_token(const std::string& list, std::size_t position) {
  return page_token(list, fmt::format("{}", position));
}

absl::StatusOr<std::size_t> page_start(const std::string& list, const std::string& token,
                                       std::size_t list_size) {
  LUCERNA_ASSIGN_OR_RETURN(const std::string text, page_position(list, token));
  if (text.empty()) return std::size_t{0};
  std::size_t start = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, start);
  if (error != std::errc() || stopped != end || start > list_size) return bad_token(token);
  return start;
}

}  // namespace lucerna::rpc

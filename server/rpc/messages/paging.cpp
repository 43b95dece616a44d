#include "server/rpc/messages/paging.h"

#include <absl/strings/escaping.h>
#include <fmt/core.h>

#include <charconv>

#include "proto/common/status_macros.h"
#include "server/rpc/messages/errors.h"

namespace lucerna::rpc {
namespace {
absl::Status bad_token(const std::string& token) {
  return bad_field("page_token", fmt::format("\"{}\"", token),
                   "empty, or next_page_token of the previous answer to the same request");
}
}  // namespace

absl::StatusOr<std::size_t> check_page_size(std::uint32_t page_size, std::uint32_t most) {
  if (page_size > most) {
    return bad_field("page_size", fmt::format("{}", page_size), fmt::format("[0, {}]", most));
  }
  return page_size == 0 ? most : page_size;
}

std::string page_token(const std::string& list, const std::string& position) {
  return absl::WebSafeBase64Escape(list + ":" + position);
}

absl::StatusOr<std::string> page_position(const std::string& list, const std::string& token) {
  if (token.empty()) return std::string();
  std::string text;
  const std::string prefix = list + ":";
  if (!absl::WebSafeBase64Unescape(token, &text) || !text.starts_with(prefix)) {
    return bad_token(token);
  }
  return text.substr(prefix.size());
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

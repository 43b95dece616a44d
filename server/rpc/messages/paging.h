// Lists in pages.
#pragma once

#include <absl/status/statusor.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "proto/common/status_macros.h"

namespace lucerna::rpc {

/// The page size; 0 means `most`.  INVALID_ARGUMENT above it.
absl::StatusOr<std::size_t> check_page_size(std::uint32_t page_size, std::uint32_t most);

/// An opaque token for `position` in `list`, which holds everything that determines the list: the
/// call, the scene and all fields of the request but those of pages.
std::string page_token(const std::string& list, const std::string& position);
/// The position; empty for an empty token.  INVALID_ARGUMENT for a token of another list, and for
/// other text.
absl::StatusOr<std::string> page_position(const std::string& list, const std::string& token);

/// The page of a list whose entries have keys, in their order.
struct Page {
  std::string list;   ///< see page_token
  std::string after;  ///< the key of the last entry before the page; empty: none
  std::size_t size;   ///< the most entries
};
/// Errors: those of check_page_size and page_position.
template <typename Request>
absl::StatusOr<Page> check_page(const Request& request, const std::string& list,
                                std::uint32_t most) {
  LUCERNA_ASSIGN_OR_RETURN(const std::size_t size, check_page_size(request.page_size(), most));
  LUCERNA_ASSIGN_OR_RETURN(std::string after, page_position(list, request.page_token()));
  return Page{list, std::move(after), size};
}
/// Calls `add` with each entry of the page, and sets the token of the next one.  `found`: the
/// entries, with at least one more if the list goes on.
template <typename Found, typename Key, typename Add, typename Response>
void put_page(const Page& page, const Found& found, const Key& key, const Add& add,
              Response* response) {
  const std::size_t n = std::min(page.size, found.size());
  for (std::size_t i = 0; i < n; ++i) add(found[i]);
  if (found.size() > n) response->set_next_page_token(page_token(page.list, key(found[n - 1])));
}

/// The same for lists that are numbered.
std::string page_token(const std::string& list, std::size_t position);
absl::StatusOr<std::size_t> page_start(const std::string& list, const std::string& token,
                                       std::size_t list_size);

}  // namespace lucerna::rpc

// Lists that arrive in pages.  This header is not installed.
#pragma once

#include <type_traits>

#include "absl/status/statusor.h"

namespace lucerna::client {

/// All pages of a list as one answer.  `call` asks for a page, and may change the request for the
/// next one.
template <typename Request, typename Call>
auto all_pages(Request request, const Call& call) {
  using Answer = typename std::invoke_result_t<const Call&, Request&>::value_type;
  Answer all;
  do {
    const absl::StatusOr<Answer> page = call(request);
    if (!page.ok()) return page;
    request.set_page_token(page->next_page_token());
    // The total of every page counts the whole list.
    if constexpr (requires { all.total(); }) all.clear_total(), all.clear_cost();
    all.MergeFrom(*page);
  } while (!request.page_token().empty());
  all.clear_next_page_token();
  return absl::StatusOr<Answer>(std::move(all));
}

}  // namespace lucerna::client

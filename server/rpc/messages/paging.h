// Lists in pages.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace lucerna::rpc {

/// The page size; 0 means `most`.  INVALID_ARGUMENT above it.
absl::StatusOr<std::size_t> check_page_size(std::uint32_t page_size, std::uint32_t most);

/// An opaque token for `position` in `list`, which holds everything that determines the list: the
/// call, the scene and all fields of the request but those of pages.
std::string page_token(const std::string& list, const std::string& position);
/// The position; empty for an empty token.  INVALID_ARGUMENT for a token of another list, and for
/// other text.
absl::StatusOr<std::string> page_position(const std::string& list, const std::string& token);

/// The same for lists that are numbered.
std::string page_token(const std::string& list, std::size_t position);
absl::StatusOr<std::size_t> page_start(const std::string& list, const std::string& token,
                                       std::size_t list_size);

}  // namespace lucerna::rpc

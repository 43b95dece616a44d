// Errors as callers see them.  Code makes an absl::Status, whose payloads are messages of
// google/rpc/error_details.proto; the one table in errors.cpp says what goes over the wire.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace lucerna::rpc {

/// INVALID_ARGUMENT "field = value, allowed: allowed", with a BadRequest field violation.
absl::Status bad_field(const std::string& field, const std::string& value,
                       const std::string& allowed);
/// INVALID_ARGUMENT for an array of the wrong length; `expected` says how the right one comes
/// about.
absl::Status bad_length(const std::string& field, std::size_t length, std::size_t expected_length,
                        const std::string& expected);
/// NOT_FOUND.
absl::Status unknown_scene(const std::string& id);
/// NOT_FOUND.
absl::Status unknown_light(std::uint64_t id);
/// UNIMPLEMENTED; `sentence` says what is and what to do instead.
absl::Status unimplemented(const std::string& sentence);
/// RESOURCE_EXHAUSTED for a request over a limit of the server's, which retrying does not help.
absl::Status over_limit(const std::string& field, std::uint64_t value, std::uint64_t limit);
/// The same error, told to be worth another try after `delay`.
absl::Status retry_after(absl::Status status, const std::string& reason,
                         std::chrono::milliseconds delay);
/// A load that failed: where time may mend it, with RetryInfo; else as it is.
absl::Status load_error(absl::Status status);
/// UNAVAILABLE: the server ends.
absl::Status draining();

/// The text, or `most` bytes of its beginning and end with "..." between them; well-formed UTF-8 as
/// before.
std::string shortened(const std::string& text, std::size_t most);

/// An error ready to be sent.
struct WireError {
  int code = 0;  ///< of gRPC
  /// Never a path outside of the scene root, never an exception's text; shortened.
  std::string message;
  std::string details;  ///< google.rpc.Status, serialised, for grpc-status-details-bin
  std::optional<std::chrono::milliseconds> pushback;  ///< for grpc-retry-pushback-ms
};
/// Requires an error.  What is not in the table is INTERNAL, without its message.
WireError to_wire(const absl::Status& status);

}  // namespace lucerna::rpc

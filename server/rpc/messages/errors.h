// Errors in the form that callers see.
//
// Code makes an absl::Status whose payloads are messages of google/rpc/error_details.proto.
// to_wire() converts it to the form that is sent.  Each error carries an ErrorInfo with the domain
// "lucerna" and one of the reasons below.
#pragma once

#include <absl/status/status.h>
#include <fmt/core.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace lucerna::rpc {

/// Why a request failed; see kErrorReasons.
enum class Reason : std::uint8_t {
  kBadField,
  kMalformedMessage,
  kInvalidInput,
  kSceneNotLoaded,
  kNoSuchLight,
  kNotFound,
  kNoSuchCall,
  kOverLimit,
  kQueueFull,
  kMemoryLeased,
  kOverQuota,
  kResourceExhausted,
  kAssetBeingUploaded,
  kWrongState,
  kCancelled,
  kDeadlinePassed,
  kDraining,
  kUnavailable,
  kNotAllowed,
  kUnauthenticated,
  kInternal,
};

struct ErrorReason {
  Reason reason;
  const char* name;       ///< ErrorInfo.reason
  absl::StatusCode code;  ///< of such errors; the numbers are those of gRPC
  const char* meaning;    ///< for users: what is wrong and what to do
};

/// Every reason, in the order of Reason.  The last one of a code is that of errors without a
/// reason. docs/api.md has this table.
inline constexpr auto kErrorReasons = [] {
  using enum absl::StatusCode;
  return std::array{
      ErrorReason{Reason::kBadField, "BAD_FIELD", kInvalidArgument,
                  "A field of the request has a value that is not allowed. BadRequest names the "
                  "field."},
      ErrorReason{Reason::kMalformedMessage, "MALFORMED_MESSAGE", kInvalidArgument,
                  "The bytes are not a message of the expected type."},
      ErrorReason{Reason::kInvalidInput, "INVALID_INPUT", kInvalidArgument,
                  "A scene file cannot be read or built. The message names file, line and column."},
      ErrorReason{Reason::kSceneNotLoaded, "SCENE_NOT_LOADED", kNotFound,
                  "No scene with this id is loaded. Load the scene again."},
      ErrorReason{Reason::kNoSuchLight, "NO_SUCH_LIGHT", kNotFound,
                  "The scene has no light with this id or name."},
      ErrorReason{Reason::kNotFound, "NOT_FOUND", kNotFound, "A file or a lease does not exist."},
      ErrorReason{Reason::kNoSuchCall, "NO_SUCH_CALL", kUnimplemented,
                  "The server has no such call. It may be older than the client."},
      ErrorReason{Reason::kOverLimit, "OVER_LIMIT", kResourceExhausted,
                  "The request exceeds a limit of the server. Send smaller requests; a retry does "
                  "not help. GetServerInfo lists the limits."},
      ErrorReason{Reason::kQueueFull, "QUEUE_FULL", kResourceExhausted,
                  "Too many requests wait, or too many answers for clients that do not take them. "
                  "RetryInfo says when to retry."},
      ErrorReason{
          Reason::kMemoryLeased, "MEMORY_LEASED", kResourceExhausted,
          "Leased scenes, loads and calls fill the memory. RetryInfo says when to retry: when the "
          "first lease ends, or soon."},
      ErrorReason{Reason::kOverQuota, "OVER_QUOTA", kResourceExhausted,
                  "The caller has used up its quota. RetryInfo says when to retry, if time helps."},
      ErrorReason{Reason::kResourceExhausted, "RESOURCE_EXHAUSTED", kResourceExhausted,
                  "The request needs more memory or disk space than the server has."},
      ErrorReason{Reason::kAssetBeingUploaded, "ASSET_BEING_UPLOADED", kFailedPrecondition,
                  "Another client uploads the same asset. RetryInfo says when to look again."},
      ErrorReason{Reason::kWrongState, "WRONG_STATE", kFailedPrecondition,
                  "The server's state does not allow this, for example because a scene is leased."},
      ErrorReason{Reason::kCancelled, "CANCELLED", kCancelled, "The client cancelled the call."},
      ErrorReason{Reason::kDeadlinePassed, "DEADLINE_PASSED", kDeadlineExceeded,
                  "The deadline of the call passed before the answer was complete."},
      ErrorReason{Reason::kDraining, "DRAINING", kUnavailable,
                  "The server shuts down. Use another server, or retry."},
      ErrorReason{Reason::kUnavailable, "UNAVAILABLE", kUnavailable,
                  "The server cannot answer now. Retry."},
      ErrorReason{Reason::kNotAllowed, "NOT_ALLOWED", kPermissionDenied,
                  "The token lacks a role, which the message names."},
      ErrorReason{Reason::kUnauthenticated, "UNAUTHENTICATED", kUnauthenticated,
                  "The call has no token, or the server does not know it."},
      ErrorReason{Reason::kInternal, "INTERNAL", kInternal,
                  "A fault of the server. The server's log has the details."},
  };
}();
constexpr const ErrorReason& entry_of(Reason reason) {
  return kErrorReasons[static_cast<std::size_t>(reason)];
}
static_assert(
    [] {
      for (std::size_t i = 0; i < kErrorReasons.size(); ++i)
        if (kErrorReasons[i].reason != static_cast<Reason>(i)) return false;
      return kErrorReasons.size() == static_cast<std::size_t>(Reason::kInternal) + 1;
    }(),
    "kErrorReasons has each reason once, in the order of Reason");

/// The error of this reason, with its code.
absl::Status error(Reason reason, const std::string& message);
/// INVALID_ARGUMENT "field = value, allowed: allowed", with a BadRequest field violation.
absl::Status bad_field(const std::string& field, const std::string& value,
                       const std::string& allowed);
/// The same with a number, and with a format for what is allowed.
template <typename Value, typename... Arguments>
absl::Status bad_field(const std::string& field, const Value& value,
                       fmt::format_string<Arguments...> allowed, Arguments&&... arguments) {
  return bad_field(field, fmt::format("{}", value),
                   fmt::format(allowed, std::forward<Arguments>(arguments)...));
}
/// INVALID_ARGUMENT for an array of the wrong length.  `expected` explains the right length.
absl::Status bad_length(const std::string& field, std::size_t length, std::size_t expected_length,
                        const std::string& expected);
/// The client sent no message where the call needs one.
absl::Status no_message();
/// NOT_FOUND.
absl::Status unknown_light(std::uint64_t id);
/// RESOURCE_EXHAUSTED for a request over a limit of the server.  A retry does not help.
absl::Status over_limit(const std::string& field, std::uint64_t value, std::uint64_t limit);
/// over_limit() if the value is.
absl::Status check_limit(const std::string& field, std::uint64_t value, std::uint64_t limit);
/// The same error with a RetryInfo: a retry after `delay` may succeed.
absl::Status retry_after(absl::Status status, Reason reason, std::chrono::milliseconds delay);
/// The error of a load, a lease or an upload.  Gets a RetryInfo if it has kRetryAfterPayload, and
/// the reason OVER_QUOTA if it has kOverQuotaPayload.  Else it stays unchanged.
absl::Status load_error(absl::Status status);

/// The text, or `most` bytes of its beginning and end with "..." between them.  Well-formed UTF-8
/// stays well-formed.
std::string shortened(const std::string& text, std::size_t most);

/// An error ready to be sent.
struct WireError {
  int code = 0;  ///< of gRPC
  /// Shortened.  Without paths outside of the scene root and without texts of exceptions.
  std::string message;
  std::string details;  ///< google.rpc.Status, serialised, for grpc-status-details-bin
  std::optional<std::chrono::milliseconds> pushback;  ///< for grpc-retry-pushback-ms
};
/// Requires an error.  A code that no reason has becomes INTERNAL without its message.
WireError to_wire(const absl::Status& status);

}  // namespace lucerna::rpc

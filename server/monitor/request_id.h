// Names of requests that clients send with them.
#pragma once

#include <string>
#include <string_view>

namespace lucerna::monitor {

/// Whether the server takes over this `x-request-id`: 1 to 128 letters, digits and `-_.:+/=@`.
/// Such a text cannot break a line of the log.
bool is_request_id(std::string_view text);
/// 16 random hexadecimal digits.  Thread-safe.
std::string make_request_id();

/// Whether the text is a W3C `traceparent` of version 00: trace, span and flags in lower-case
/// hexadecimal digits, with trace and span not zero.  https://www.w3.org/TR/trace-context
bool is_traceparent(std::string_view text);

/// The text with "?" for each character that is no letter, digit or `-_.:+/=@*`, and at most 128 of
/// them.  For names that others chose, such as those of certificates.
std::string printable_name(std::string_view text);

/// Whether the text is the id of a scene: 64 lower-case hexadecimal digits.
bool is_scene_id(std::string_view text);

}  // namespace lucerna::monitor

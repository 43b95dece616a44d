// The form of the lines of the log: text for people, or JSON for programs.
#pragma once

#include <spdlog/formatter.h>

#include <cstdint>
#include <memory>
#include <string>

namespace lucerna::monitor {

enum class LogFormat : std::uint8_t { kText, kJson };

/// Lines of the logger of this name are the members of a JSON object already, if the format is
/// JSON.
inline constexpr char kMembersLogger[] = "members";

/// Text: "2026-11-23T23:10:13.905+00:00 [info] ended".
/// JSON: {"time":"2026-11-23T23:10:13.905+00:00","level":"info","message":"ended"}
std::unique_ptr<spdlog::formatter> make_formatter(LogFormat format);

/// The text as a JSON string.  Bytes that are not UTF-8 are replaced.
std::string json_string(const std::string& text);

}  // namespace lucerna::monitor

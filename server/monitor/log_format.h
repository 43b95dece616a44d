// The form of the lines of the log: text for people, or JSON for programs.
#pragma once

#include <spdlog/formatter.h>
#include <spdlog/sinks/sink.h>

#include <cstdint>
#include <memory>
#include <string>

#include "server/monitor/log_limit.h"

namespace lucerna::monitor {

enum class LogFormat : std::uint8_t { kText, kJson };

/// Lines of the logger of this name are the members of a JSON object already, if the format is
/// JSON.
inline constexpr char kMembersLogger[] = "members";

/// Text: "2026-11-23T23:10:13.905+00:00 [info] ended".
/// JSON: {"time":"2026-11-23T23:10:13.905+00:00","level":"info","message":"ended"}
std::unique_ptr<spdlog::formatter> make_formatter(LogFormat format);

/// A sink that writes at most a number of lines per second to `out`, and says how many it left out.
std::shared_ptr<spdlog::sinks::sink> limited(std::shared_ptr<spdlog::sinks::sink> out,
                                             std::shared_ptr<LogLimit> limit);

/// The text as a JSON string.  Bytes that are not UTF-8 are replaced.
std::string json_string(const std::string& text);

/// The line that says that lines are missing.
std::string describe_left_out(std::uint64_t lines);

}  // namespace lucerna::monitor

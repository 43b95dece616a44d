#include "server/monitor/call_log.h"

#include <fmt/format.h>

#include <cstring>
#include <iterator>
#include <utility>

namespace lucerna::monitor {
namespace {

// SampleLi of lucerna.v1.LightingService/SampleLi.
const char* short_name(Call call) { return std::strrchr(name_of(call), '/') + 1; }

}  // namespace

std::string describe(const CallRecord& record, LogFormat format) {
  const bool json = format == LogFormat::kJson;
  fmt::memory_buffer line;
  const auto out = std::back_inserter(line);
  const auto key = [&](const char* name) {
    if (json) {
      fmt::format_to(out, ",\"{}\":", name);
    } else {
      fmt::format_to(out, " {}=", name);
    }
  };
  // These texts hold neither quotes nor control characters: see CallRecord.
  const auto text = [&](const char* name, const std::string& value) {
    if (value.empty()) return;
    key(name);
    fmt::format_to(out, "{}", json ? json_string(value) : value);
  };
  const auto count = [&](const char* name, std::uint64_t value) {
    if (value == 0) return;
    key(name);
    fmt::format_to(out, "{}", value);
  };
  const auto milliseconds = [&](const char* name, double seconds) {
    key(name);
    fmt::format_to(out, "{:.3f}", 1e3 * seconds);
  };
  if (json) {
    fmt::format_to(out, "\"message\":\"call\",\"call\":\"{}\"", short_name(record.call));
  } else {
    fmt::format_to(out, "call {}", short_name(record.call));
  }
  text("code", code_name(record.code));
  text("id", record.request_id);
  text("peer", record.peer);
  text("caller", record.caller);
  text("scene", record.scene_id);
  count("items", record.items);
  count("samples", record.samples);
  if (record.queued) text("lane", name_of(record.lane));
  milliseconds("queue_ms", record.queue_s);
  milliseconds("compute_ms", record.compute_s);
  milliseconds("total_ms", record.total_s);
  text("traceparent", record.traceparent);
  return fmt::to_string(line);
}

CallLog::CallLog(LogFormat format, spdlog::level::level_enum level, std::shared_ptr<LogLimit> limit)
    : format_(format), limit_(std::move(limit)), logger_(kMembersLogger, limit_->out()) {
  logger_.set_level(level);
}

void CallLog::write(const CallRecord& record) {
  if (logger_.should_log(spdlog::level::info) && limit_->take())
    logger_.info(describe(record, format_));
}

}  // namespace lucerna::monitor

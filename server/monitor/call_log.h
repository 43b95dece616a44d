// Writes one line of log for each call.
#pragma once

#include <spdlog/logger.h>

#include <memory>
#include <string>

#include "server/monitor/call_record.h"
#include "server/monitor/log_format.h"
#include "server/monitor/log_limit.h"

namespace lucerna::monitor {

/// "call SampleLi code=OK id=3f1c... peer=ipv4:127.0.0.1:40000 ...", or the members of a JSON
/// object.  Times are in milliseconds.
std::string describe(const CallRecord& record, LogFormat format);

/// Thread-safe.  Calls are logged at the level info; the details of INTERNAL errors have a line of
/// their own.
class CallLog {
 public:
  /// Writes to the sink of `limit`.
  CallLog(LogFormat format, spdlog::level::level_enum level, std::shared_ptr<LogLimit> limit);

  void write(const CallRecord& record);
  std::uint64_t left_out() const { return limit_->left_out(); }

 private:
  LogFormat format_;
  std::shared_ptr<LogLimit> limit_;
  spdlog::logger logger_;
};

}  // namespace lucerna::monitor

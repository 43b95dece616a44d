// A sink of the log that never waits for whoever reads it.
#pragma once

#include <spdlog/sinks/base_sink.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>

namespace lucerna::monitor {

/// Writes lines to a descriptor while it takes them.  Lines that come while a pipe is full are left
/// out and counted.  The next line that it takes says how many.  Thread-safe.
class UnblockingSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  /// `descriptor` stays open as long as the sink.
  explicit UnblockingSink(int descriptor) : descriptor_(descriptor) {}

  std::uint64_t left_out() const { return left_out_; }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override { (void)write_waiting(); }

 private:
  void append(const spdlog::details::log_msg& message);
  /// Writes `waiting_` as far as nobody must wait.  True if nothing is left of it.
  bool write_waiting();

  const int descriptor_;
  std::atomic<std::uint64_t> left_out_ = 0;
  std::uint64_t reported_ = 0;
  std::string waiting_;  // at most two lines, perhaps without their beginning
};

}  // namespace lucerna::monitor

// Limits how many lines a log gets in a second.
#pragma once

#include <spdlog/sinks/sink.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace lucerna::monitor {

/// A sink that passes lines on.  A token bucket: at most `lines_per_second` lines in a burst, and
/// as many in each further second.  After lines that it left out, it writes how many they were.
/// Thread-safe.
class LogLimit final : public spdlog::sinks::sink {
 public:
  using Clock = std::chrono::steady_clock;

  /// 0: no limit.  `now` is the clock.
  LogLimit(std::shared_ptr<spdlog::sinks::sink> out, std::uint64_t lines_per_second,
           std::function<Clock::time_point()> now = &Clock::now);

  /// Whether the next line may be written to out().
  bool take();
  const std::shared_ptr<spdlog::sinks::sink>& out() const { return out_; }
  /// All lines left out so far.
  std::uint64_t left_out() const;

  void log(const spdlog::details::log_msg& message) override {
    if (take()) out_->log(message);
  }
  void flush() override { out_->flush(); }
  void set_pattern(const std::string& pattern) override { out_->set_pattern(pattern); }
  void set_formatter(std::unique_ptr<spdlog::formatter> formatter) override {
    out_->set_formatter(std::move(formatter));
  }

 private:
  const std::shared_ptr<spdlog::sinks::sink> out_;
  const double rate_;
  const std::function<Clock::time_point()> now_;
  mutable std::mutex mutex_;
  double tokens_;
  Clock::time_point filled_;
  std::uint64_t left_out_ = 0, reported_ = 0;
};

}  // namespace lucerna::monitor

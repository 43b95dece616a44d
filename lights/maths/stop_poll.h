// Ends long loops after a request to stop, without a parameter in each function on the way to them.
#pragma once

#include <cstdint>
#include <exception>
#include <stop_token>
#include <utility>

namespace lucerna {

/// What a StopPoll throws.
struct Stopped : std::exception {
  const char* what() const noexcept override { return "stopped"; }
};

/// While it lives, the polls of its thread look at `stop`, which must outlive it.
class StopScope {
 public:
  explicit StopScope(const std::stop_token& stop) : outer_(std::exchange(current_, &stop)) {}
  ~StopScope() { current_ = outer_; }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

  /// That of the innermost scope of this thread.
  static std::stop_token token() { return current_ == nullptr ? std::stop_token() : *current_; }
  /// Throws Stopped after a request to stop.
  static void check() {
    if (current_ != nullptr && current_->stop_requested()) throw Stopped();
  }

 private:
  static inline constinit thread_local const std::stop_token* current_ = nullptr;
  const std::stop_token* outer_;
};

/// For loops over the content of files and requests.  Without a scope it does nothing.
///
///     StopPoll poll;
///     for (std::size_t i = 0; i < triangles.size(); ++i, poll()) ...
class StopPoll {
 public:
  /// Throws Stopped after a request to stop.  Looks once in 256 calls, so steps may take 50 us.
  void operator()() {
    if (++calls_ % 256 == 0) StopScope::check();
  }

 private:
  std::uint32_t calls_ = 0;
};

}  // namespace lucerna

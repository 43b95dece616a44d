// Signals of the process, on a thread of their own.  Nothing runs in a signal handler.
#pragma once

#include <functional>
#include <thread>

namespace lucerna {

/// Takes SIGTERM, SIGINT, SIGHUP, SIGUSR1 and SIGUSR2 away from their default action, which ends
/// the process.  Ignores SIGPIPE.
class Signals {
 public:
  /// Calls `on_signal` with the number of each signal, one at a time.  Construct this before any
  /// other thread, because threads inherit the signal mask.
  explicit Signals(std::function<void(int)> on_signal);
  /// Waits for a running `on_signal`.
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

 private:
  int signals_ = -1;  // descriptor that is readable when a signal waits
  int wake_ = -1;     // descriptor that ends the thread
  std::function<void(int)> on_signal_;
  std::thread thread_;
};

}  // namespace lucerna

// Messages to systemd, if it started the process.  Without systemd they do nothing.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace lucerna {

/// Sends a state such as "READY=1" (see sd_notify(3)).
void notify_service_manager(const std::string& state);

/// Tells systemd regularly that the process works, if the unit sets WatchdogSec=.  systemd restarts
/// a process that stops doing so.
class Watchdog {
 public:
  /// Calls `works` in a thread of its own, twice in each interval.  If it returns false, systemd
  /// gets no message.
  explicit Watchdog(std::function<bool()> works);

 private:
  std::jthread thread_;
};

}  // namespace lucerna

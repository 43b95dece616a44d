#include "server/runtime/service_manager.h"

#include <systemd/sd-daemon.h>

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>

namespace lucerna {

void notify_service_manager(const std::string& state) { sd_notify(0, state.c_str()); }

Watchdog::Watchdog(std::function<bool()> works) {
  std::uint64_t interval_us = 0;
  if (sd_watchdog_enabled(0, &interval_us) <= 0) return;
  thread_ = std::jthread([works = std::move(works), interval_us](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any ended;
    while (!stop.stop_requested()) {
      if (works()) notify_service_manager("WATCHDOG=1");
      std::unique_lock lock(mutex);
      ended.wait_for(lock, stop, std::chrono::microseconds(interval_us / 2), [] { return false; });
    }
  });
}

}  // namespace lucerna

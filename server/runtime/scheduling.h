// How the operating system schedules the calling thread.  On Linux each thread has its own values,
// and threads inherit those of the thread that starts them.
#pragma once

#include <cstdint>

namespace lucerna {

/// The niceness of this thread, -20 to 19.
int thread_niceness();
/// Keeps the present niceness if the process may not set this one.  Only a privileged process may
/// lower a niceness.
void set_thread_niceness(int niceness);

enum class TimeSlice : std::uint8_t {
  kDefault,  ///< the system's own
  kShort     ///< 0.1 ms, the least
};
/// The length of this thread's turns on a processor.  A thread with shorter turns than the running
/// one replaces it when it wakes, instead of waiting for up to a timer tick.  Its share of the
/// processors stays the same, so it cannot starve others.  Linux before 6.12 ignores this.
void set_time_slice(TimeSlice slice);
/// This thread's time slice [ns]; 0 if the system does not tell.
std::uint64_t time_slice_ns();

}  // namespace lucerna

#include "server/runtime/scheduling.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <optional>

namespace lucerna {
namespace {

constexpr std::uint64_t kShortSliceNs = 100'000;

/// `struct sched_attr` of the kernel's first version.  The headers of Debian 12 conflict with each
/// other there, and its C library has no function for these calls.
struct SchedulingAttributes {
  std::uint32_t size = sizeof(SchedulingAttributes);
  std::uint32_t policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0;
  std::uint64_t deadline_ns = 0;
  std::uint64_t period_ns = 0;
};

std::optional<SchedulingAttributes> attributes() {
  SchedulingAttributes now;
  if (syscall(SYS_sched_getattr, 0, &now, sizeof now, 0) != 0) return std::nullopt;
  // Threads of other policies have no time slice of this kind.
  if (now.policy != SCHED_OTHER && now.policy != SCHED_BATCH) return std::nullopt;
  return now;
}

}  // namespace

int thread_niceness() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

void set_thread_niceness(int niceness) {
  if (niceness != thread_niceness())
    (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), niceness);
}

void set_time_slice(TimeSlice slice) {
  auto wanted = attributes();
  if (!wanted) return;
  // Zero asks for the default.
  wanted->runtime_ns = slice == TimeSlice::kShort ? kShortSliceNs : 0;
  (void)syscall(SYS_sched_setattr, 0, &*wanted, 0);
}

std::uint64_t time_slice_ns() {
  const auto now = attributes();
  return now ? now->runtime_ns : 0;
}

}  // namespace lucerna

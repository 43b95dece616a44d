#include "server/monitor/process_figures.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "server/runtime/memory.h"

namespace lucerna::monitor {
namespace {

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

std::uint64_t entries(const char* directory) {
  std::error_code error;
  const std::filesystem::directory_iterator begin(directory, error);
  if (error) return 0;
  std::uint64_t n = 0;
  for (auto i = begin; i != std::filesystem::directory_iterator(); i.increment(error)) {
    if (error) break;
    ++n;
  }
  return n;
}

}  // namespace

v1::ProcessStats process_figures() {
  v1::ProcessStats figures;
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0)
    figures.set_cpu_s(seconds(usage.ru_utime) + seconds(usage.ru_stime));
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0) figures.set_most_descriptors(limit.rlim_cur);
  figures.set_resident_bytes(resident_bytes());
  // The listing itself opens one descriptor.
  const std::uint64_t open = entries("/proc/self/fd");
  figures.set_open_descriptors(open - std::min<std::uint64_t>(open, 1));
  figures.set_threads(entries("/proc/self/task"));
  return figures;
}

}  // namespace lucerna::monitor

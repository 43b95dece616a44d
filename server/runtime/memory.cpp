#include "server/runtime/memory.h"

#include <malloc.h>
#include <unistd.h>

#include <cstddef>
#include <fstream>

// jemalloc's control function, with its C declaration.  lucernad links jemalloc.  Test programs and
// sanitizers have other allocators, where this is null.
extern "C" [[gnu::weak]] int mallctl(const char* name, void* old_value, size_t* old_size,
                                     void* new_value, size_t new_size);

namespace lucerna {

void return_free_memory() {
  if (mallctl != nullptr) {
    // 4096 is jemalloc's MALLCTL_ARENAS_ALL: all arenas.
    mallctl("arena.4096.purge", nullptr, nullptr, nullptr, 0);
  } else {
    malloc_trim(0);
  }
}

std::uint64_t allocated_bytes() {
  if (mallctl == nullptr) {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
  }
  // jemalloc's figures are those of the last epoch.
  std::uint64_t epoch = 1;
  mallctl("epoch", nullptr, nullptr, &epoch, sizeof epoch);
  size_t bytes = 0, size = sizeof bytes;
  mallctl("stats.allocated", &bytes, &size, nullptr, 0);
  return bytes;
}

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t all_pages = 0, resident_pages = 0;
  statm >> all_pages >> resident_pages;
  return resident_pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace lucerna

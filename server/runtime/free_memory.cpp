#include "server/runtime/free_memory.h"

#include <malloc.h>

#include <cstddef>

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

}  // namespace lucerna

// The memory of the process.
#pragma once

#include <cstdint>

namespace lucerna {

/// Returns freed memory to the operating system.  Takes up to some milliseconds.  Otherwise the
/// allocator keeps it for a while, and the memory budget does not count it.
void return_free_memory();

/// Memory that was allocated and not freed yet [bytes].  Some of it may not have been used yet.
std::uint64_t allocated_bytes();
/// Memory that the operating system has given [bytes].  Some of it may have been freed.
std::uint64_t resident_bytes();

}  // namespace lucerna

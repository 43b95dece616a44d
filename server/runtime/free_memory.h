// Memory that the allocator keeps after it is freed.
#pragma once

namespace lucerna {

/// Returns freed memory to the operating system.  Takes up to some milliseconds.  Otherwise the
/// allocator keeps it for a while, and the memory budget does not count it.
void return_free_memory();

}  // namespace lucerna

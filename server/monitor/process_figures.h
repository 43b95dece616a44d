// What the operating system reports of this process.
#pragma once

#include <cstdint>

namespace lucerna::monitor {

struct ProcessFigures {
  double cpu_s = 0;  ///< processor time of all threads
  std::uint64_t resident_bytes = 0;
  std::uint64_t open_descriptors = 0;
  std::uint64_t most_descriptors = 0;  ///< the limit (ulimit -n)
  std::uint64_t threads = 0;
};

/// Reads /proc/self.  A figure that cannot be read is 0.
ProcessFigures process_figures();

}  // namespace lucerna::monitor

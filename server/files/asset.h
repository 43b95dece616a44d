// Name and digest of a file that a scene was read from.
#pragma once

#include <cstdint>
#include <string>

namespace lucerna {

/// One file that was read, for digests.
struct Asset {
  std::string name;    ///< relative to the scene root
  std::string sha256;  ///< 32 bytes
  std::uint64_t bytes = 0;
};

}  // namespace lucerna

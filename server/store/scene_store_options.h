// Options of a SceneStore.  A separate file, so that programs can set them without the store's
// header.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "server/files/load_limits.h"

namespace lucerna {

struct SceneStoreOptions {
  std::string root = ".";  ///< the directory that paths are relative to
  std::string isa{};       ///< Embree's kernels; empty: the best of the machine
  /// Memory of all scenes together; 0: no limit.
  std::uint64_t memory_budget_bytes = 0;
  /// Memory of the pictures of surfaces in one scene; larger ones are halved.  0: no limit.
  std::uint64_t texture_bytes = std::uint64_t{1} << 30;
  LoadLimits load{};  ///< without `texture_bytes` and `budget`
  /// The longest lease [s].
  double max_lease_s = 86400;
  /// The clock of leases.
  std::function<std::chrono::steady_clock::time_point()> now = &std::chrono::steady_clock::now;
};

}  // namespace lucerna

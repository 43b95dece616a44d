// The power of lights from samples of rays that leave them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "proto/common/confidence.h"
#include "server/estimate/pilots.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

struct SampledPowerSettings {
  std::uint64_t seed = 0;
  std::uint32_t samples_per_block = 1;  ///< at most 2^28
  std::uint32_t block_count = 16;       ///< independent blocks; 1: no standard error
  /// If set, each light takes its own `samples_per_block`, as many as the target needs. The limit
  /// is max_samples / block_count, which must be 1 or more.  Intervals have the target's
  /// `confidence`, else kConfidence.
  std::optional<TargetError> target{};
};

struct SampledPower {
  Rgb lumens;
  double standard_error_lm = 0;    ///< of the luminous flux; infinite if block_count is 1
  ConfidenceInterval interval_lm;  ///< for the luminous flux, with the confidence of the settings
  std::uint64_t samples = 0;       ///< samples of the estimate
};

struct SampledPowers {
  std::vector<SampledPower> lights;
  SampledPower total;  ///< its `samples` is the sum over all lights
  WorkCounts work;
  bool stopped = false;
};

/// The power of each of `lights`, by index: the mean of the quotient that SampleLeResponse in
/// lucerna/v1/lighting.proto defines.  The scene's sphere bounds lights at infinity.  The
/// answer for a light depends only on its id and the settings.  Runs in the caller's oneTBB
/// arena.
SampledPowers sample_powers(const Scene& scene, std::span<const std::uint32_t> lights,
                            const SampledPowerSettings& settings, std::stop_token stop);

}  // namespace lucerna

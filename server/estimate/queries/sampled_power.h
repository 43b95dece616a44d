// The power of lights by sampling the rays that leave them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/estimate/paths/render.h"
#include "server/estimate/statistics/confidence.h"
#include "server/scene/scene.h"

namespace lucerna {

struct SampledPowerSettings {
  std::uint64_t seed = 0;
  std::uint32_t samples_per_block = 1;  ///< at most 2^28
  std::uint32_t block_count = 16;       ///< independent replicates; 1: no standard error
  /// Set: `samples_per_block` is each light's own, as many as this takes, at most
  /// max_samples / block_count, which is 1 or more.  Intervals are of its `confidence`, else of
  /// kConfidence.
  std::optional<TargetError> target{};
};

struct SampledPower {
  Rgb<double> lumens;
  double standard_error_lm = 0;  ///< of the luminous flux; infinite where block_count is 1
  Interval interval_lm;          ///< holds the luminous flux with the confidence
  std::uint64_t samples = 0;     ///< that it is made of
};

struct SampledPowers {
  std::vector<SampledPower> lights;
  SampledPower total;  ///< its samples are those of all lights
  WorkCounts work;
  bool stopped = false;
};

/// The power of each of `lights`, by their indices: the mean of what SampleLeResponse in
/// lucerna/v1/lighting.proto says, of lights at infinity with the scene's sphere.  A light's answer
/// is a function of its id and the settings, whatever the others.  Runs in the oneTBB arena of the
/// caller.
SampledPowers sample_powers(const Scene& scene, std::span<const std::uint32_t> lights,
                            const SampledPowerSettings& settings, std::stop_token stop);

}  // namespace lucerna

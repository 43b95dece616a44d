// What samples of light say of the light at their receivers, and how many samples that takes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/estimate/paths/render.h"
#include "server/estimate/queries/li_sampler.h"
#include "server/estimate/statistics/confidence.h"

namespace lucerna {

/// Samples in each of `replicates` that every receiver needs for `target`, each by itself; 0 where
/// one sample says all (one_sample_says_all), or why there is none.  The samples that tell are of
/// replicates that no answer has.  Requires the query's `seed`.  Adds what it took to `work`;
/// nothing where it was stopped.
std::optional<std::vector<std::uint32_t>> samples_needed(
    const LiSampler& sampler, std::size_t receivers, const TargetError& target,
    std::uint32_t replicates, const std::stop_token& stop, WorkCounts& work);

/// As many for each receiver, but 0 as above.
std::vector<std::uint32_t> equally_many(const LiSampler& sampler, std::size_t receivers,
                                        std::uint32_t samples_per_replicate);

/// Of each receiver.
struct LiEstimates {
  /// Irradiance where the receivers have normals, else spherical irradiance.
  std::vector<IrradianceEstimate> points;
  /// kInvalidInput or kOutOfRange where one of its samples is, else kOk.
  std::vector<ItemResult> results;
  /// At wavelength k, of receiver r: [r * wavelengths + k] [W/m2/nm]; standard errors.
  std::vector<double> spectral, spectral_error;
};

/// Of all samples of an answer: what they say, what came of them and, sample by sample, their
/// values at `wavelengths` wavelengths.
LiEstimates estimates_of(const LiLayout& layout, std::size_t receivers, std::uint32_t replicates,
                         double confidence, std::span<const LiShare> shares,
                         std::span<const int> status, std::span<const float> spectral_value,
                         std::size_t wavelengths);

}  // namespace lucerna

// Estimates from samples of light at receivers, and the number of samples for a target error.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "server/estimate/pilots.h"
#include "server/queries/li_sampler.h"
#include "server/queries/receiver_irradiance.h"

namespace lucerna {

/// The number of samples in each of `blocks` that each receiver needs for `target`, independent
/// of the other receivers.  0 if one sample is enough (one_sample_is_enough) or the receiver is
/// invalid.  Pilot samples come from blocks that no answer uses.  Requires the query's `seed`.
/// Adds the cost to `work`.  Nothing if it was stopped.
std::optional<std::vector<std::uint32_t>> samples_needed(
    const LiSampler& sampler, std::size_t receivers, const TargetError& target,
    std::uint32_t blocks, const std::stop_token& stop, WorkCounts& work);

/// The same number for each receiver, but 0 in the cases above.
std::vector<std::uint32_t> equally_many(const LiSampler& sampler, std::size_t receivers,
                                        std::uint32_t samples_per_block);

/// Estimates for each receiver.
struct LiEstimates {
  /// Irradiance if the receivers have normals, else spherical irradiance.
  std::vector<IrradianceEstimate> points;
  /// kInvalidInput or kOutOfRange if one of the samples has it, else kOk.
  std::vector<ItemResult> results;
  /// At wavelength k of receiver r: [r * wavelengths + k] [W/m2/nm]; and standard errors.
  std::vector<double> spectral, spectral_error;
};

/// Estimates from all samples of an answer: their shares, their status and, sample by sample,
/// their values at `wavelengths` wavelengths.
LiEstimates estimates_of(const LiSampler& sampler, const LiLayout& layout, std::size_t receivers,
                         std::uint32_t blocks, double confidence, std::span<const LiShare> shares,
                         std::span<const int> status, std::span<const float> spectral_value,
                         std::size_t wavelengths);

}  // namespace lucerna

// Numbers of the contract that server and client both need: defaults and limits that
// proto/lucerna/v1 states at its fields.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lucerna {

/// Samples of a receiver or of a light come in this many independent blocks.  Their scatter
/// gives the standard error to about a fifth.
inline constexpr std::uint32_t kDefaultBlocks = 16;
/// Samples for each receiver of EstimateIrradiance, unless the request says otherwise.
inline constexpr std::uint32_t kIrradianceSamples = 256;
/// TargetError.max_samples, unless the request says otherwise.
inline constexpr std::uint32_t kTargetSamples = 65536;
/// The least TargetError.max_samples: fewer samples do not show how many are needed.
inline constexpr std::uint32_t kLeastTargetSamples = 64;
/// The most Accuracy.samples_per_light, and `samples` of a light in a scene file.
inline constexpr std::uint32_t kMostSamplesPerLight = 1024;
/// The most `wavelengths_nm` of one request.
inline constexpr std::size_t kMostWavelengths = 128;
/// The most BlenderLevels.lumens_per_watt.
inline constexpr double kMostLumensPerWatt = 1e6;

}  // namespace lucerna

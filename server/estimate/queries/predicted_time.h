// Processor time that queries are predicted to take.
//
// Predictions decide where a request runs: at once, in the interactive lane or in the bulk lane.
// They are upper estimates in seconds: the time per item of one core on the reference scenes,
// rounded up.
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/estimate/queries/irradiance.h"
#include "server/estimate/queries/queries.h"

namespace lucerna {

/// One value at one wavelength [s].
inline constexpr double kWavelengthSeconds = 5e-9;

/// `le` of this many rays [s].
double le_seconds(std::size_t rays, std::size_t wavelengths);
/// `sample_le` of this many rays [s].
double sample_le_seconds(std::size_t rays, std::size_t wavelengths);
/// `pdf_li` and `pdf_le` of this many items [s].  A density searches all primitives of the light.
double pdf_seconds(const Light& light, std::size_t items);
/// `sample_li` of this many samples [s].
double sample_li_seconds(const SampleLiQuery& query, double samples);
/// `test_visibility` of this many items [s].
double visibility_seconds(std::size_t items);
/// `light_power` of this many lights [s].
double power_seconds(std::size_t lights, std::size_t wavelengths);
/// `sample_powers` of this many samples for each light [s].
double sampled_power_seconds(std::size_t lights, std::uint64_t samples);
/// The samples of `estimate_irradiance`, this many for each point [s].
double irradiance_samples_seconds(const Scene& scene, const IrradianceSettings& settings,
                                  std::size_t points, std::uint64_t samples);
/// The time of `estimate_irradiance` without samples: spectra, and parts of the scene that the
/// first query makes [s].
double irradiance_fixed_seconds(const Scene& scene, const IrradianceSettings& settings,
                                std::size_t points);
/// The time to make parts of the scene that `methods` need and that no query has made yet [s].
double first_use_seconds(const Scene& scene, const Methods& methods);

}  // namespace lucerna

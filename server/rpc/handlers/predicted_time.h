// Processor time that queries are predicted to take.
//
// Predictions decide where a request runs: at once, in the interactive lane or in the bulk lane.
// They are upper estimates in seconds: the time per item of one core on the reference scenes,
// rounded up.
#pragma once

#include <cstddef>

#include "server/estimate/methods.h"
#include "server/scene/scene.h"
#include "server/visibility/shadow_maps.h"

namespace lucerna::rpc {

/// One value at one wavelength [s].
inline constexpr double kWavelengthSeconds = 5e-9;
/// A ray through surfaces, with its point [s].
inline constexpr double kRaySeconds = 1.5e-6;

/// Items of `seconds` each, with a value at each wavelength [s].
inline double seconds_of(std::size_t items, double seconds, std::size_t wavelengths = 0) {
  return static_cast<double>(items) *
         (seconds + static_cast<double>(wavelengths) * kWavelengthSeconds);
}

/// The time to make parts of the scene that `methods` need and that no query has made yet [s].
inline double first_use_seconds(const Scene& scene, const Methods& methods) {
  return methods.visibility == VisibilityMethod::kShadowMaps ? shadow_maps(scene).seconds_left()
                                                             : 0;
}

}  // namespace lucerna::rpc

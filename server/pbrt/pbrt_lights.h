// Converts LightSource directives to lights.  As in pbrt-v4, spectra have luminance 1 before
// `scale`; `power` or `illuminance` then multiplies the level.
#pragma once

#include <cstdint>
#include <string>

#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The light of a LightSource directive.  Fails on unknown types and on parameters
/// that the light model refuses.
LightDescription make_light(LoadState& context, const ParameterSet& params,
                            const Transform& world_from_light);

/// "integer samples": points on the light for each sample.  pbrt-v3 has this parameter, pbrt-v4
/// does not.
std::uint32_t samples_of(const ParameterSet& params);

/// "string name": the light's name; empty if it is not given.  pbrt-v4 does not have it.
std::string name_of(const ParameterSet& params);

}  // namespace lucerna::pbrt

// Levels of lights that a float has no room for.
#pragma once

#include <string_view>

#include "lights/spectra/rgb.h"
#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// Ends the refusal of a "power" or "illuminance" to a light that is black.
inline constexpr const char* kOnlyAsIfNotGiven = ", allowed: 0, as if not given";

/// The parameter that such a level is said to come from, the first that is given of "scale",
/// "power", "illuminance", `name` (of its colour) and "filename"; `directive` where none is.
Place level_place(const ParameterSet& params, std::string_view name, const Place& directive);

/// Fails where floats do not hold all channels of `value`; "what = (r, g, b), allowed: ...".
void require_level(const Place& place, std::string_view what, const Rgb<double>& value);

}  // namespace lucerna::pbrt

// Levels of lights: the multiplier that "scale", "power" and "illuminance" give, and its limits.
#pragma once

#include <string_view>

#include "lights/maths/rgb.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The end of the error for a "power" or "illuminance" of a black light.
inline constexpr const char* kOnlyAsIfNotGiven = ", allowed: 0, which counts as not given";

/// The "power" or "illuminance" that a light accepts.
struct LevelTarget {
  const char* name;      ///< of the parameter
  const char* unit;      ///< "lm" or "lx"
  double of_unit_level;  ///< the power or illuminance of the light at luminance 1
};

/// Level (intensity, radiance or illuminance) of a light: the colour in `name` times "scale".  If
/// the target is given, the level is also multiplied by its value over `of_unit_level`, so a light
/// of luminance 1 reaches the target.  Fails on negative values, and on a target for a black light.
Rgb light_level_with_target(LoadState& context, const ParameterSet& params, const char* name,
                            const LevelTarget& target);

/// The "scale" of a level, 1 if it is not given.  Fails on negative values.
double level_scale(const ParameterSet& params);

/// The "power" or "illuminance" of this name that a light has to reach; 0 if it is not given. Fails
/// on negative values.  Adds a remark that 0 means `instead`.
double target_of(LoadState& context, const ParameterSet& params, const char* name,
                 const std::string& instead);

/// The "float `name`" if its value is positive; null otherwise.
const Parameter* positive_parameter(const ParameterSet& params, std::string_view name);

/// The place in errors about a level: the first one that is given of "scale", "power",
/// "illuminance", `name` (the colour) and "filename"; that of the directive if none is given.
FilePosition level_place(const ParameterSet& params, std::string_view name);

/// Fails if a channel of `value` does not fit a float: "what = (r, g, b), allowed: ...".
void require_level(const FilePosition& place, std::string_view what, const Rgb& value);

}  // namespace lucerna::pbrt

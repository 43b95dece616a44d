// LightSource "projection".  Beyond what pbrt-v4 reads:
//   "string projection" perspective (pbrt-v4's) | orthographic: a beam of parallel rays
//   "float extent"      shorter side of an orthographic beam [m], 1
//   "string filter"     nearest (pbrt-v4's) | bilinear
//   "rgb I" or a spectrum, as pbrt-v2 and pbrt-v3 had it: what the picture is multiplied by
//   without "string filename" a square that is lit evenly
#pragma once

#include <variant>

#include "server/pbrt/images.h"

namespace lucerna::pbrt {

/// The light but for its level, which is 1: intensity of a perspective one, illuminance of a beam.
struct Projection {
  std::variant<ProjectionLightParams, BeamLightParams> light;
  double lumens;        ///< what a level of luminance 1 amounts to
  double pbrt4_lumens;  ///< the same as pbrt-v4 counts it for "power"
};

/// Scale along the light's axes changes what the picture covers, as it does with pbrt-v4; fails on
/// transforms that leave the axes at other angles.
Projection projection(Context& context, const ParameterSet& params, const Place& place,
                      const Transform& world_from_light);

/// With the level set.  `level_place`: where a level that is too high is given.  `power_place`:
/// where "power" is given, else null; a remark there says the flux where pbrt-v4 counts another.
void set_level(Context& context, const Place& level_place, const Place* power_place,
               const Rgb<double>& level, Projection& projection);

}  // namespace lucerna::pbrt

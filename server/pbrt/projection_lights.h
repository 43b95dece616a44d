// LightSource "projection".  Parameters that pbrt-v4 does not have:
//   "string projection" perspective (pbrt-v4's) | orthographic: a beam of parallel rays
//   "float extent"      shorter side of an orthographic beam [m], default 1
//   "string filter"     nearest (pbrt-v4's) | bilinear
//   "rgb I" or a spectrum, from pbrt-v2 and pbrt-v3: multiplies the picture
//   without "string filename" the light is an evenly lit square
#pragma once

#include <variant>

#include "server/pbrt/pbrt_images.h"

namespace lucerna::pbrt {

/// The light with level 1: an intensity for a perspective projection, an illuminance for a beam.
struct Projection {
  std::variant<ProjectionLightParams, BeamLightParams> light;
  double lumens;        ///< luminous flux of level 1
  double pbrt4_lumens;  ///< the same as pbrt-v4 computes it, for "power"
};

/// Reads the directive.  Scale along the light's axes changes the area that the picture covers, as
/// in pbrt-v4.  Fails on transforms that change the angles between the axes.
Projection projection(LoadState& context, const ParameterSet& params,
                      const Transform& world_from_light);

/// Sets the level.  `level_place`: place of an error about a level that is too high. `power_place`:
/// place of "power", or null.  Adds a remark with the flux there if pbrt-v4 computes another flux.
void set_level(LoadState& context, const FilePosition& level_place, const FilePosition* power_place,
               const Rgb& level, Projection& projection);

}  // namespace lucerna::pbrt

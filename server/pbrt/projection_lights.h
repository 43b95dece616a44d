// LightSource "projection".  Beyond what pbrt-v4 reads:
//   "string projection" perspective (pbrt-v4's) | orthographic: a beam of parallel rays
//   "float extent"      shorter side of an orthographic beam [m], default 1
//   "string filter"     nearest (pbrt-v4's) | bilinear
//   "rgb I" or a spectrum, from pbrt-v2 and pbrt-v3: multiplies the picture
//   without "string filename" the light is an evenly lit square
#pragma once

#include <variant>

#include "server/pbrt/images.h"

namespace lucerna::pbrt {

/// The light with level 1: intensity for a perspective one, illuminance for a beam.
struct Projection {
  std::variant<ProjectionLightParams, BeamLightParams> light;
  double lumens;        ///< luminous flux of level 1
  double pbrt4_lumens;  ///< the same by pbrt-v4's count, for "power"
};

/// Reads the directive.  Scale along the light's axes changes the area that the picture covers,
/// like in pbrt-v4.  Fails on transforms that change the angles between the axes.
Projection projection(Context& context, const ParameterSet& params, const Place& place,
                      const Transform& world_from_light);

/// Sets the level.  `level_place`: place of an error about a level that is too high.
/// `power_place`: place of "power", or null; a remark there gives the flux if pbrt-v4 counts
/// another one.
void set_level(Context& context, const Place& level_place, const Place* power_place,
               const Rgb<double>& level, Projection& projection);

}  // namespace lucerna::pbrt

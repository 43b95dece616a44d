// Infinite lights with a picture.  Beyond what pbrt-v4 reads:
//   "string mapping" equalarea (pbrt-v4's) | latlong (+y at the top, as HDRIs are)
//   "string filter"  nearest (pbrt-v4's) | bilinear
#pragma once

#include "server/pbrt/images.h"

namespace lucerna::pbrt {

/// LightSource "infinite" with "string filename": a texel of value 1 is 1 cd/m2 times "scale".
/// Fails on "L" beside it, on a transform of unequal scale, and on a picture that the mapping
/// cannot take.
ImageInfiniteLightParams image_infinite(Context& context, const ParameterSet& params,
                                        const Place& place, const Transform& world_from_light);

/// "string mapping" of a light.
SphereMapping sphere_mapping(const ParameterSet& params);

}  // namespace lucerna::pbrt

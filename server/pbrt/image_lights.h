// Infinite lights with a picture, with a portal, or with both.  Beyond what pbrt-v4 reads:
//   "string mapping" equalarea (pbrt-v4's) | latlong (+y at the top, as HDRIs are)
//   "string filter"  nearest (pbrt-v4's) | bilinear
// Behind a portal an equal-area picture without "filter" is resampled as pbrt-v4 does it; with one,
// and a latlong one (bilinear by itself), it is looked at directly.
#pragma once

#include "lights/models/image_infinite_light.h"
#include "lights/models/portal_light.h"
#include "server/pbrt/images.h"

namespace lucerna::pbrt {

/// LightSource "infinite" with "string filename": a texel of value 1 is 1 cd/m2 times "scale".
/// Fails on "L" beside it, on a transform of unequal scale, and on a picture that the mapping
/// cannot take.
ImageInfiniteLightParams image_infinite(Context& context, const ParameterSet& params,
                                        const Place& place, const Transform& world_from_light);

/// LightSource "infinite" with "point3 portal", whose corners are in world space whatever the
/// transform, and with or without "string filename".  The radiance of a picture is set, without one
/// it is left to the caller.  Fails as `image_infinite` does, and on corners that are no rectangle.
PortalLightParams portal(Context& context, const ParameterSet& params, const Place& place,
                         const Transform& world_from_light);

/// "string mapping" of a light.
SphereMapping sphere_mapping(const ParameterSet& params);

/// Of a light without a picture: remarks that "string mapping" and "string filter", those of
/// `names` that the directive itself gives, change nothing.  Fails on values that they cannot have.
void check_without_picture(Context& context, const ParameterSet& params,
                           std::initializer_list<std::string_view> names);

}  // namespace lucerna::pbrt

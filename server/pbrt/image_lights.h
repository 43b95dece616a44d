// Infinite lights with a picture, with a portal, or with both.  Parameters that pbrt-v4 does not
// have:
//   "string mapping" equalarea (pbrt-v4's) | latlong (+y at the top, the usual layout of HDRIs)
//   "string filter"  nearest (pbrt-v4's) | bilinear
// Behind a portal, an equal-area picture without "filter" is resampled as in pbrt-v4.  A picture
// with "filter" is read directly.  So is a latlong picture, whose default is bilinear.
#pragma once

#include "lights/models/image_infinite_light.h"
#include "lights/models/portal_light.h"
#include "server/pbrt/pbrt_images.h"

namespace lucerna::pbrt {

/// LightSource "infinite" with "string filename": a texel of value 1 is 1 cd/m2 times "scale".
/// Fails if "L" is given too, on a transform of unequal scale, and on a picture that the mapping
/// cannot use.
ImageInfiniteLightParams image_infinite(LoadState& context, const ParameterSet& params,
                                        const Transform& world_from_light);

/// LightSource "infinite" with "point3 portal", with or without "string filename". The corners are
/// in world space; the transform does not apply to them.  The radiance of a picture is set; without
/// a picture the caller sets it.  Fails as `image_infinite` does, and on corners that are not a
/// rectangle.
PortalLightParams portal(LoadState& context, const ParameterSet& params,
                         const Transform& world_from_light);

/// The "string mapping" of a light; equalarea if it is not given.
SphereMapping sphere_mapping(const ParameterSet& params);

/// For a light without a picture: adds remarks that "string mapping" and "string filter" have no
/// effect. Considers only those of `names` that the directive itself gives.  Fails on invalid
/// values.
void check_without_picture(LoadState& context, const ParameterSet& params,
                           std::initializer_list<std::string_view> names);

}  // namespace lucerna::pbrt

// Whether points lie inside of solids, such as furniture, or behind lamps.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/rays/ray.h"
#include "server/scene/scene.h"

namespace lucerna {

/// True if a shape encloses the position of a receiver, or if a lamp covers it.  Depends only on
/// its arguments.
///
/// A lamp covers the point if a ray along the receiver's normal first meets the back of a one-sided
/// area light, at most 1/16 of the diagonal of the light's box away.  So a point of a ceiling above
/// a panel is covered.
///
/// The rule for shapes: a point on a surface is replaced by one just before it, on the side of the
/// receiver's normal.  So a receiver on the floor below furniture is inside.  From the point, 16
/// rays in fixed directions are followed through all surfaces.  They count the crossings of each
/// shape: +1 from back to front (leaving), -1 from front to back.  Normals point to the front.  A
/// shape encloses the point if
/// - the count is positive along 4 rays or more, and negative along none;
/// - each ray with the count 0 meets a surface, and the place just before it is inside of the
///   shape.  Most rays that lead away from there have positive counts.  So furniture that touches
///   the floor is closed, although a ray finds only one of two surfaces at one place;
/// - of the first 64 lights that have a place, none is inside of the shape, except the shape's own
///   light.  So a closed room around its lamps is not a solid.
///
/// Not found: solids whose normals point inwards, solids of several open shapes, shapes with gaps.
/// Wrongly found: a closed room of one shape, normals outwards, without lamps.
bool is_inside_solid(const Scene& scene, const SurfaceHit& receiver);

/// The same for many receivers, 1 for true, in the oneTBB arena of the caller.  Not valid if `stop`
/// was requested.
std::vector<std::uint8_t> inside_solids(const Scene& scene, std::span<const SurfaceHit> receivers,
                                        const std::stop_token& stop);

}  // namespace lucerna

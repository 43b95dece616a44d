// Whether points lie inside of solids, such as furniture.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "server/estimate/queries/irradiance.h"

namespace lucerna {

/// True if a shape encloses the point.  Deterministic: a function of its arguments alone.
///
/// The rule: the point is on no surface.  From it, 16 rays in fixed directions are followed through
/// all surfaces, and the crossings of each shape are counted: +1 by the side of the normals
/// (leaving), -1 by the other side.  A shape encloses the point if
/// - the count is positive along 4 rays or more, and negative along none;
/// - a ray with the count 0 first meets some surface, and the point just before that surface is
///   inside of the shape along most rays with positive counts that lead away from it.  So furniture
///   that touches the floor is closed, although a ray finds only one of two surfaces at one place;
/// - of the first 64 lights that have a place, none is inside of the shape, but for the shape's own
///   light.  So a closed room around its lamps is not a solid.
///
/// Not found: solids whose normals point inwards, solids of several open shapes, shapes with gaps.
/// Wrongly found: a closed room of one shape, normals outwards, without lamps.
bool is_inside_solid(const Scene& scene, const IrradiancePoint& point, double time_s);

/// The same of many points, 1 for true, in the oneTBB arena of the caller.  Of no use where `stop`
/// was requested.
std::vector<std::uint8_t> inside_solids(const Scene& scene, std::span<const IrradiancePoint> points,
                                        double time_s, const std::stop_token& stop);

}  // namespace lucerna

// How far the rounding of coordinates may move the edge of a shadow over a small light.
#pragma once

#include <cstdint>

#include "server/rays/ray.h"
#include "server/scene/scene.h"

namespace lucerna {

/// The light that rounding may add or take [lx] if a surface hides a part of the light from the
/// receiver.  0 for infinite lights and for those larger than 0.003 of their distance.
/// `most_lx`: an upper bound of the light that arrives.
double light_at_shadow_edges(const Scene& scene, const SurfaceHit& receiver, std::uint32_t light,
                             double most_lx);

}  // namespace lucerna

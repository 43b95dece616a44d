// The cone of directions in which a distribution of intensity has light.
#pragma once

#include "lights/maths/vec.h"

namespace lucerna {

/// All directions with light lie within `half_angle_rad` of `axis`, in the distribution's own axes.
/// The cone may be slightly too large, never too small.
struct EmissionCone {
  Vec3 axis{0, 0, 1};  ///< unit
  double half_angle_rad{};
};

}  // namespace lucerna

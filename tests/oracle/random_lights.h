// Random lights without a surface.
#pragma once

#include "tests/oracle/numbers.h"
#include "tests/oracle/world.h"

namespace lucerna::oracle {

/// Where a random scene is, and how large.
struct Stage {
  Real scale = 1;
  Vec origin;
  Vec across, along, axis{0, 0, 1};  ///< unit vectors; a ground lies across the axis
  /// A point in units of the scale about the origin, in doubles.
  Vec over(double x, double y, double z) const {
    return doubles(origin + (across * x + along * y + axis * z) * scale);
  }
};

Texels random_texels(Numbers& random, int width, int height);
/// Unit vectors at right angles, in doubles; the third is `w`.
std::array<Vec, 3> random_frame(Numbers& random, const Vec& w);
Light random_light(Numbers& random, const Stage& stage);

}  // namespace lucerna::oracle

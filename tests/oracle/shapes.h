// What the oracle knows of single shapes.
#pragma once

#include <numbers>
#include <vector>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

inline constexpr Real kPi = std::numbers::pi_v<Real>;

/// The corners of flat shapes; for disks and spheres the corners of a box around them.
std::vector<Vec> hull(const Shape& shape);
/// Of a flat shape, unit, on the side that emits.
Vec normal_of(const Shape& shape);
/// The corners of a polygon around the flat shape, in order.
std::vector<Vec> surroundings(const Shape& shape);
/// How far inside of the flat shape's border a point of its plane lies; negative outside, where it
/// is at most the distance.  `n`: normal_of(shape).
Real inside_by(const Shape& shape, const Vec& n, const Vec& p);

}  // namespace lucerna::oracle

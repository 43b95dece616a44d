// An order of rays in which neighbours traverse the same parts of the BVH.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

/// The numbers of rays in the order of a Morton code of their middles.  Empty if the
/// given order is as good: few rays, or rays that are near their neighbours already.  `middles`:
/// any numbers.
///
/// Middles are better than both ends.  In a cube of a million small triangles, two threads traced
/// 0.49 million random segments per second in the given order, 0.61 in the order of both ends and
/// 0.66 in the order of their middles.
std::vector<std::uint32_t> coherent_order(std::span<const Vec3f> middles);

}  // namespace lucerna

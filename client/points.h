// From double-precision points to the contract's batches of single-precision offsets.
#pragma once

#include <array>
#include <span>

#include "lucerna/v1/accuracy.pb.h"

namespace lucerna::client {

/// A point or a vector in world coordinates.
using Double3 = std::array<double, 3>;

/// World points [m], each coordinate within 2^-24 of the largest offset along its axis; a
/// coordinate that all points share (a plane, a single point) is exact.  Far from zero the offsets
/// are from the points' middle, so that they keep their differences.
v1::Points make_points(std::span<const Double3> points);

}  // namespace lucerna::client

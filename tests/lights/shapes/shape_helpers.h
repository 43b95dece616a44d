// What the tests of single shapes share.
#pragma once

#include <limits>

#include "lights/maths/transform.h"

namespace lucerna::testing {

/// The end of rays without an end [m].
inline constexpr double kFar = std::numeric_limits<double>::infinity();

/// For matrices with an inverse.
inline Transform matrix(const Transform::Matrix& m) { return *Transform::from_matrix(m); }

}  // namespace lucerna::testing

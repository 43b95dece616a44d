// Constants of rounding-error analysis for geometry in floats.
#pragma once

#include <limits>

namespace lucerna {

/// Unit roundoff of float, 2^-24: the relative error of one rounding to nearest.
inline constexpr double kFloatRoundoff = std::numeric_limits<float>::epsilon() / 2.0;

/// gamma_n = n u / (1 - n u): bound on the relative error of n roundings in sequence.
/// [Higham02, 3.1]
constexpr double gamma_bound(int n, double roundoff = kFloatRoundoff) {
  return n * roundoff / (1 - n * roundoff);
}

/// Embree tests a triangle in single precision about the ray's origin.  The distance to the plane
/// is dot(n, v0 - o), n = cross(e1, e2).  There is one rounding in each of v0 - o, e1 and e2, three
/// in a cross product, three in a dot product, and one in the division.  So the error of the
/// distance is at most gamma_16 |v0 - o| if n is well conditioned. tests/server/rays/ray_test.cpp
/// passes with this bound.  With a sixteenth of it, it finds false shadows.
inline constexpr double kTraversalBound = gamma_bound(16);
inline constexpr float kTraversalError = static_cast<float>(kTraversalBound);

/// The least error of floats at any place [m]: differences below the smallest normal float are 0
/// (server/runtime/denormals.h).  A position, each component of a ray's offset and of its direction
/// may have this error.
inline constexpr float kLeastError = 16 * std::numeric_limits<float>::min();

}  // namespace lucerna

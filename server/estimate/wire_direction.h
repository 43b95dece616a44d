// Directions as floats in messages.  Lights compute in double.  Value and density in an answer must
// belong to the three floats that the caller reads.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// The unit vector, in double, of three floats in a message.
inline Vec3 direction_of(const Vec3f& w) { return normalized(Vec3(w)); }

/// Not inlined: GCC 12 at -O2 drops the rounding where the floats become doubles again.
[[gnu::noinline]] inline Vec3f as_floats(const Vec3& v) { return Vec3f(v); }

/// Finds floats for the unit vector `w`.  Tries the nearest floats first, then their neighbours,
/// because rounding may lead over the rim of a light.  Returns the first candidate for which
/// `holds(direction_of(candidate))` is true.  Nothing if the light is narrower than the distance
/// between directions in floats.
template <typename F>
std::optional<Vec3f> wire_direction(const Vec3& w, const F& holds) {
  const Vec3f nearest = as_floats(w);
  const auto around = [](float x) {
    return std::array{x, std::nextafter(x, -INFINITY), std::nextafter(x, INFINITY)};
  };
  for (const float x : around(nearest.x))
    for (const float y : around(nearest.y))
      for (const float z : around(nearest.z))
        if (const Vec3f candidate{x, y, z}; holds(direction_of(candidate))) return candidate;
  return std::nullopt;
}

}  // namespace lucerna

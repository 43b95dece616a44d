// Directions as the wire's floats tell them: lights answer in double, and what is told of a
// direction has to be true of the one that the caller reads.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "lights/maths/vec.h"

namespace lucerna {

/// What three floats of a request mean: unit, in double.
inline Vec3<double> direction_of(const Vec3<float>& w) { return normalized(Vec3<double>(w)); }

/// Not inlined: GCC 12 at -O2 goes on with doubles where floats become doubles again.
[[gnu::noinline]] inline Vec3<float> as_floats(const Vec3<double>& v) { return Vec3<float>(v); }

/// Looks for the floats that tell the unit vector `w`: the nearest first, then those around it, as
/// rounding may lead over the rim of a light.  Returns the first that `holds` of direction_of them;
/// nothing where the light is narrower than floats tell directions apart.
template <typename F>
std::optional<Vec3<float>> told_direction(const Vec3<double>& w, const F& holds) {
  const Vec3<float> nearest = as_floats(w);
  const auto around = [](float x) {
    return std::array{x, std::nextafter(x, -INFINITY), std::nextafter(x, INFINITY)};
  };
  for (const float x : around(nearest.x))
    for (const float y : around(nearest.y))
      for (const float z : around(nearest.z))
        if (const Vec3<float> told{x, y, z}; holds(direction_of(told))) return told;
  return std::nullopt;
}

}  // namespace lucerna

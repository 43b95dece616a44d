// What transforms stretch, for lights that only some transforms leave what they are.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "lights/maths/transform.h"
#include "server/pbrt/place.h"

namespace lucerna::pbrt {

/// The factors by which a transform stretches along three directions at right angles, ascending:
/// the singular values of its linear part.  [Golub13]
std::array<double, 3> scales_of(const Transform& transform);

/// "scales 1, 1 and 2".
std::string scales_text(const Transform& transform);

/// Fails where `transform` stretches lengths unequally.  `what`: "a spot".
void require_equal_scale(const Place& place, std::string_view what, const Transform& transform);

}  // namespace lucerna::pbrt

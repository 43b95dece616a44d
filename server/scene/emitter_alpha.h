// Lights whose surfaces are cut out.
#pragma once

#include <optional>
#include <string>

#include "server/description/scene_description.h"

namespace lucerna {

/// Multiplies the radiance of a shape that emits by its alpha: what rays see of it on the average.
/// An alpha that varies becomes a picture.  Where that is not possible, the shape becomes opaque,
/// and the result is a remark.
std::optional<std::string> apply_alpha(ShapeDescription& shape, const Textures& textures);

}  // namespace lucerna

// Lights whose surfaces are cut out.
#pragma once

#include "server/description/scene_description.h"

namespace lucerna {

/// Multiplies the radiance of each shape that emits by its alpha: what rays see of it on the
/// average.  An alpha that varies becomes a picture.  Where that is not possible, the shape becomes
/// opaque, and the scene gets a remark.  Returns whether any alpha was below 1.
bool apply_alpha(SceneDescription& scene);

}  // namespace lucerna

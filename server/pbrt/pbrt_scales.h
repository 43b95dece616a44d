// Scale factors of transforms, for lights that only allow equal scale.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "lights/maths/transform.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The scale factors along three perpendicular directions: "scales 1, 1 and 2".
std::string scales_text(const Transform& transform);

/// The `own_space` of a light model; null for equal scale.  Adds a remark if "power" is given,
/// which pbrt-v4 measures without the transform.
std::shared_ptr<const Frame> own_space_of(LoadState& context, const ParameterSet& params,
                                          const Transform& world_from_light);

/// Fails if `transform` scales lengths unequally.  `what`: "a spot".
void require_equal_scale(const FilePosition& place, std::string_view what,
                         const Transform& transform);

}  // namespace lucerna::pbrt

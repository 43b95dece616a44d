// What loads and pictures say of light that queries may miss.
#pragma once

#include <optional>

#include "server/description/scene_description.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Whether there are such surfaces and lights.
bool may_miss_light(const Scene& scene);
/// Names the smooth surfaces and the lights between which no paths are computed.  Nothing if there
/// are none.
std::optional<Remark> remark_on_smooth_surfaces(const Scene& scene);

}  // namespace lucerna

// Finds the shapes that portals leave dark.
#pragma once

#include <absl/status/status.h>

#include <stop_token>

#include "server/description/scene_description.h"

namespace lucerna {

/// Adds a remark for each portal whose light comes from a side with shapes.  Errors: CANCELLED.
absl::Status remark_on_portals(SceneDescription& scene, const std::stop_token& stop);

}  // namespace lucerna

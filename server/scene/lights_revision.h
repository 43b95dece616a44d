// The lights of a scene with edits.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <stop_token>

#include "server/scene/light_edit.h"
#include "server/scene/scene_geometry.h"
#include "server/scene/scene_lights.h"

namespace lucerna {

/// `geometry`: with the surfaces of these edits.  Lights without edits, and all blocks of such
/// lights, stay shared with `loaded`, which has no edits.  Errors: a change that its light does not
/// allow; a level or a place out of range; CANCELLED.
absl::StatusOr<std::shared_ptr<const SceneLights>> revised_lights(const SceneLights& loaded,
                                                                  const SceneGeometry& geometry,
                                                                  const LightEdits& edits,
                                                                  const std::stop_token& stop);

}  // namespace lucerna

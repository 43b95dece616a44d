// Moves and adds surfaces of lights, without building everything else again.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <stop_token>

#include "server/scene/light_edit.h"
#include "server/scene/scene_geometry.h"
#include "server/scene/scene_lights.h"

namespace lucerna {

/// What these edits change of the surfaces of a scene without edits.
SurfaceEdits surface_edits(const SceneLights& loaded, const LightEdits& edits);

/// The geometry of a scene without edits, with these edits.  It shares the BVH of all other
/// surfaces.  Null if the scene must be built with them: if they change the origin, the unit of
/// rays or the number of triangles of a surface.  Also null if `from` was built with other moves.
/// Errors: edits that their light does not allow.
absl::StatusOr<std::shared_ptr<const SceneGeometry>> moved_geometry(
    const SceneGeometry& from, const SceneLights& loaded, const SurfaceEdits& edits,
    const std::stop_token& stop = {});

}  // namespace lucerna

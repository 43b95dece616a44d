// Prepares the surfaces of a scene for rays.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <stop_token>
#include <string>

#include "server/files/load_budget.h"
#include "server/scene/scene_frame.h"
#include "server/scene/scene_geometry.h"

namespace lucerna {

/// Leaves out media that absorb nothing, and interfaces between equal media.
void simplify_media(SceneDescription& scene);

/// Moves shapes, materials, textures and media out of `scene`.  `has_cut_lights`: as in
/// FixedGeometry.  `moved`: surfaces that are not where the scene's file has them.  `budget` may be
/// null.  Errors: those of append_shape and Accelerator::build.
absl::StatusOr<std::shared_ptr<const SceneGeometry>> build_geometry(
    SceneDescription& scene, const ShapeExtents& extents, const Vec3& origin, bool has_cut_lights,
    const MovedSurfaces& moved, const std::string& isa, const std::stop_token& stop,
    LoadBudget* budget);

}  // namespace lucerna

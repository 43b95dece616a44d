// Where a scene is: the zero of its coordinates, its extent, and those of its objects.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <stop_token>
#include <vector>

#include "lights/sampling/light_sample.h"
#include "server/description/scene_description.h"
#include "server/rays/surface_table.h"

namespace lucerna {

/// CANCELLED after a request to stop.  For every loop over the content of a scene.
inline absl::Status check_stop(const std::stop_token& stop) {
  return stop.stop_requested() ? absl::CancelledError("the build was cancelled") : absl::OkStatus();
}

/// The coordinates of a scene.
struct SceneFrame {
  Vec3 origin;         ///< world position of their zero [m]
  SceneSphere sphere;  ///< contains geometry and local lights; radius 0 if there are none
};

/// Where the shapes of a scene are, over their motion.
struct ShapeExtents {
  Bounds world_m;                              ///< of all
  Bounds others_m;                             ///< of all but those of lights that edits can move
  double detail_m = Bounds::kInfinity;         ///< the extent of the smallest
  double others_detail_m = Bounds::kInfinity;  ///< of the smallest of `others_m`
  std::vector<Vec3> object_origins;            ///< of each object
  std::vector<Vec3> moving_origins;            ///< of each moving shape
};

/// The origin of a scene or an object with these bounds: the centre rounded to a multiple of the
/// smallest power of two that is not below the extent.
Vec3 origin_for(const Bounds& bounds);

/// Adds the bounds of a shape to those of all, and to the extent of the smallest shape.
void add_shape(const Bounds& shape, Bounds& all, double& detail_m);

/// Errors: shapes without bounds, motion out of the range of rays.
absl::StatusOr<ShapeExtents> shape_extents(const SceneDescription& scene,
                                           const std::stop_token& stop);

/// The frame of a scene with shapes in these bounds and these lights beside them.  Errors: motion
/// out of the range of rays.
absl::StatusOr<SceneFrame> scene_frame(const Bounds& shapes_m,
                                       const LongList<LightDescription>& lights,
                                       const std::stop_token& stop);

}  // namespace lucerna

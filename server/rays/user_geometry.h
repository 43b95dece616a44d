// What Embree asks back for while it looks for hits: shapes that it does not know, and instances
// that move.  This file, user_geometry.cpp and accelerator.cpp alone know Embree.
#pragma once

#include <embree3/rtcore.h>

#include <vector>

#include "lights/maths/motion.h"
#include "server/rays/accelerator.h"
#include "server/rays/ray_limits.h"
#include "server/rays/surface_table.h"

namespace lucerna {

/// Embree hands the context of a query through to the callbacks: the moment and the exact hit
/// travel in it.
struct QueryContext {
  explicit QueryContext(double time_s) : time_s(time_s) { rtcInitIntersectContext(&embree); }

  RTCIntersectContext embree;  // first, so that its address is this object's
  double time_s;
  Vec3<double> position, normal;
};

/// The shapes of one kind within a set.
struct AnalyticShapes {
  const GeometrySet* set;
  HitKind kind;
};

/// An instance that moves: its rays are taken into the object's space in double, rounded to floats
/// once there (ray_limits.h), and the object's own scene is asked.
struct MovingInstance {
  /// `box`: of the object [m].  `number`: what hits name it by.
  MovingInstance(const GeometryInstance& instance, RTCScene object, const RaySpace& space,
                 const Bounds& box, double scene_unit_m, unsigned number);

  RTCScene object;  ///< refers to
  unsigned number;
  std::shared_ptr<const Motion> motion;
  Transform object_from_start;  ///< from where `motion` starts
  RaySpace space;               ///< the object's
  double scene_unit_m;
  RTCBounds swept;  ///< in the scene's units, over all time
};

/// Geometries for Embree, not committed yet, whose callbacks refer to `shapes` and `instances`.
RTCGeometry analytic_geometry(RTCDevice device, AnalyticShapes* shapes, std::size_t count);
RTCGeometry moving_geometry(RTCDevice device, std::vector<MovingInstance>* instances);

}  // namespace lucerna

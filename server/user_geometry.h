// What Embree asks back for while it looks for hits: shapes that it does not know, and instances
// that move.  This file, user_geometry.cpp and accelerator.cpp alone know Embree.
#pragma once

#include <embree3/rtcore.h>

#include <vector>

#include "lights/motion.h"
#include "server/accelerator.h"

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
/// once there, their directions as long as suits the object (ray_limits.h), and the object's own
/// scene is asked.
struct MovingInstance {
  /// `bounds`: of the object.  `number`: what hits name it by.
  MovingInstance(const GeometryInstance& instance, RTCScene object, const RTCBounds& bounds,
                 unsigned number);

  RTCScene object;  ///< refers to
  unsigned number;
  std::shared_ptr<const Motion> motion;
  Transform object_from_start;  ///< from where `motion` starts
  int direction_exponent;       ///< of the longest component, in the object's space
  RTCBounds swept;              ///< in the scene's space, over all time
};

/// Geometries for Embree, not committed yet, whose callbacks refer to `shapes` and `instances`.
RTCGeometry analytic_geometry(RTCDevice device, AnalyticShapes* shapes, std::size_t count);
RTCGeometry moving_geometry(RTCDevice device, std::vector<MovingInstance>* instances);

}  // namespace lucerna

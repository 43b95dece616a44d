// Callbacks for Embree: for shapes that it does not have, and for instances that move.  Only this
// file, user_geometry.cpp and accelerator.cpp use Embree.
#pragma once

#include <embree3/rtcore.h>

#include <vector>

#include "lights/maths/motion.h"
#include "server/rays/accelerator.h"
#include "server/rays/ray_limits.h"
#include "server/rays/surface_table.h"

namespace lucerna {

// Geometry numbers within an Embree scene: the kinds of primitives by HitKind, then these.  In the
// top scene, instances follow.
enum GeometryId : unsigned { kWide = kHitKinds, kMoving, kFirstInstance };

/// Embree passes the context of a query to the callbacks.  It has the time and the end of the
/// query, the surfaces that it meets, and the exact hit.
struct QueryContext {
  QueryContext(double time_s, float t_max, Meets meets, const GeometryInstance* instances)
      : time_s(time_s), t_max(t_max), meets(meets), instances(instances) {
    rtcInitIntersectContext(&embree);
  }

  RTCIntersectContext embree;  // first, so that its address is this object's
  double time_s;
  float t_max;  ///< of the ray in the space that Embree traverses
  Meets meets;
  const GeometryInstance* instances;  ///< of the scene, from kFirstInstance on
  /// Set if the query wants all hits: it takes each of them, and the ray goes on.
  std::vector<RawHit>* kept = nullptr;
  Vec3<double> position, normal;
};

/// The shapes of one kind within a set.
struct AnalyticShapes {
  const GeometrySet* set;
  HitKind kind;
};

/// A moving instance.  Rays are converted to the object's space in double, rounded to floats
/// once there (ray_limits.h), and traced in the object's own scene.
struct MovingInstance {
  /// `box`: of the object [m].  `number`: the instance of hits.
  MovingInstance(const GeometryInstance& instance, RTCScene object, const RaySpace& space,
                 const Bounds& box, double scene_unit_m, unsigned number);

  RTCScene object;  ///< not owned
  unsigned number;
  std::shared_ptr<const Motion> motion;
  Transform object_from_start;  ///< from the start of `motion`
  RaySpace space;               ///< the object's
  double scene_unit_m;
  RTCBounds swept;  ///< in the scene's units, over all time
};

/// Lets the geometry of `set`'s triangles reject hits of rays along a triangle that do not meet it,
/// and hits that the ray passes (Meets).
void check_along(RTCGeometry triangles, GeometrySet* set);

/// Makes Embree geometries, not yet committed.  Their callbacks refer to `shapes`, `set` and
/// `instances`.  A hit on a wide triangle is one of the geometry kTriangle.
RTCGeometry analytic_geometry(RTCDevice device, AnalyticShapes* shapes, std::size_t count);
RTCGeometry wide_geometry(RTCDevice device, GeometrySet* set);
RTCGeometry moving_geometry(RTCDevice device, std::vector<MovingInstance>* instances);

}  // namespace lucerna

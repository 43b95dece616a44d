// Callbacks for Embree: for shapes that it does not have, and for instances that move.  Only
// accelerator_build.cpp, accelerator.cpp, accelerator_state.h and user_geometry.{h,cpp} use Embree.
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
  /// `instances`: of the scene, from kFirstInstance on.
  QueryContext(double time_s, float t_max, RayFilter filter, const GeometryInstance* instances)
      : time_s(time_s), t_max(t_max), filter(filter), instances(instances) {
    rtcInitIntersectContext(&embree);
  }

  RTCIntersectContext embree;  // first, so that its address is this object's
  double time_s;
  float t_max;  ///< of the ray in the space that Embree traverses
  RayFilter filter;
  const GeometryInstance* instances;
  /// The scene's own primitives that rays pass, because they are elsewhere; null if there are none.
  const std::vector<PrimitiveRange>* hidden = nullptr;
  /// Set if the query wants all hits: it takes each of them, and the ray goes on.
  std::vector<RawHit>* kept = nullptr;
  /// Set if the ends of the ray may lie on surfaces.  The query then ignores surfaces on which an
  /// end may lie, and sets `may_be_own`.
  const EndTolerances* ends = nullptr;
  bool may_be_own = false;
  Vec3 position, normal;
};

/// The primitives of one kind within a set, from `first` on.
struct PrimitivesOfSet {
  const GeometrySet* set = nullptr;
  HitKind kind{};
  std::uint32_t first = 0;  ///< the number in the set of Embree's primitive 0
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

/// Installs a filter on the triangles.  It rejects false hits of rays nearly parallel to a
/// triangle, and hits on surfaces that the ray passes (RayFilter).
void check_along(RTCGeometry geometry, PrimitivesOfSet* triangles);

/// Makes Embree geometries, not yet committed.  Their callbacks refer to `shapes`, `large` and
/// `instances`.  `large->first` is an index of GeometrySet::large.  A hit on a large triangle is
/// one of the geometry kTriangle, with the number of the triangle in the set.
RTCGeometry analytic_geometry(RTCDevice device, PrimitivesOfSet* shapes, std::size_t count);
RTCGeometry large_geometry(RTCDevice device, PrimitivesOfSet* large, std::size_t count);
RTCGeometry moving_geometry(RTCDevice device, std::vector<MovingInstance>* instances);

}  // namespace lucerna

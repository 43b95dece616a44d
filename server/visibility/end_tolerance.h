// The ends of rays that lie on surfaces: their own surfaces do not block them.
#pragma once

#include <cmath>
#include <optional>

#include "lights/maths/vec.h"
#include "server/rays/ray.h"
#include "server/scene/scene.h"

namespace lucerna {

/// A ray from a point without a normal starts this many position errors away from the point.
/// Every point of a cube of half edge e lies within sqrt(3) e of its centre.  So a ray that leaves
/// a plane in the cube at more than asin(sqrt(3) / 16) = 6 degrees cannot meet that plane again.
/// With a normal there is no such limit.
inline constexpr float kStartWithoutNormal = 16;

/// A bound on the coordinates of all surfaces, which bounds their rounding.
inline double largest_coordinate(const Scene& scene) {
  return max_abs(scene.sphere().center_m) + scene.sphere().radius_m;
}

/// The extent of the error of a hit along the surface's normal.
inline double normal_error_of(const SurfaceHit& hit) {
  return std::fabs(hit.ng.x) * hit.position_error.x + std::fabs(hit.ng.y) * hit.position_error.y +
         std::fabs(hit.ng.z) * hit.position_error.z;
}

/// Whether a point with exact coordinates lies in the plane of a hit, up to the rounding of its
/// vertices.  The ends of `first_other_surface` that are exact count alike.
bool lies_in_plane(const Vec3& exact, const SurfaceHit& hit);

/// The first surface that `ray` meets, except those that its ends lie on.
std::optional<SurfaceHit> first_other_surface(const Scene& scene, Ray ray,
                                              const EndTolerances& ends,
                                              RayFilter filter = RayFilter::kSurfaces);

/// Whether `ray` meets a surface that its ends do not lie on.  In most cases one traversal decides.
bool is_blocked(const Scene& scene, const Ray& ray, const EndTolerances& ends, RayFilter blocking);

}  // namespace lucerna

#include "server/visibility/end_tolerance.h"

#include <limits>

#include "server/rays/error_bounds.h"

namespace lucerna {
namespace {

/// How far the rounding of its vertices moves a surface along its normal.  The error of a hit is
/// larger: it is that of many roundings.
double rounding_of(const SurfaceHit& hit) {
  const auto across = [](double n, double p) { return std::fabs(n * p); };
  return kFloatRoundoff * (across(hit.ng.x, hit.position.x) + across(hit.ng.y, hit.position.y) +
                           across(hit.ng.z, hit.position.z)) +
         normal_error_of(hit) * (kFloatRoundoff / kTraversalBound);
}

/// Whether the plane of `hit` passes `point` at a distance of at most twice the sum of `error` and
/// its own rounding.
bool plane_passes(const SurfaceHit& hit, const Vec3& point, double error) {
  return std::fabs(dot(hit.ng, hit.position - point)) <= 2 * (error + rounding_of(hit));
}

/// Whether two hits are on one surface: on one shape, or in one plane, such as the floors of two
/// rooms.
bool continues(const SurfaceHit& a, const SurfaceHit& b) {
  return a.shape == b.shape || (plane_passes(a, b.position, rounding_of(b)) &&
                                plane_passes(b, a.position, rounding_of(a)));
}

/// Whether the surface of `hit` is found at `place` too, within `reach` along its normal.
bool is_found_at(const Scene& scene, const Vec3& place, double reach, const EndTolerance& end,
                 const SurfaceHit& hit) {
  // Other surfaces may be equally near, such as a carpet or a sheet of paper.
  constexpr int kMostSurfaces = 16;
  Ray ray{Vec3f(place + hit.ng * reach), -Vec3f(hit.ng), 0, static_cast<float>(2 * reach),
          hit.time_s};
  for (int i = 0; i < kMostSurfaces; ++i) {
    const auto found = scene.closest_hit(ray);
    if (!found) return false;
    if (plane_passes(*found, end.position, end.error) && continues(*found, hit)) return true;
    ray.t_min = std::nextafter(found->t, INFINITY);
  }
  return false;
}

/// Whether the point lies on the surface that was hit.  The surface's plane must pass the point,
/// and the surface must be found near the point.  A ray that grazes the point's own surface comes
/// within its error long before the end.  A distant shelf in the plane of the point is another
/// surface, even if the point's error is large.
bool lies_on(const Scene& scene, const EndTolerance& end, const SurfaceHit& hit) {
  if (!(end.error >= 0) || !plane_passes(hit, end.position, end.error)) return false;
  const Vec3 apart = hit.position - end.position;
  const double near = kStartWithoutNormal * (end.error + max_abs(hit.position_error));
  if (length(apart) <= near) return true;
  // A point at the rim of its surface may be rounded off it.  The direction to the hit leads back.
  const Vec3 inwards = normalized(apart) * near;
  return is_found_at(scene, end.position, near, end, hit) ||
         is_found_at(scene, end.position + inwards, near, end, hit);
}

/// Whether the ends are on different sides of the surface's plane.  A straight line crosses the
/// plane at the hit only, so a hit between the ends separates them, also on a curved surface.
bool separates(const SurfaceHit& hit, const EndTolerances& ends) {
  const double start = dot(hit.ng, ends.start.position - hit.position);
  const double end = dot(hit.ng, ends.end.position - hit.position);
  return (start > 0 && end < 0) || (start < 0 && end > 0);
}

}  // namespace

bool lies_in_plane(const Vec3& exact, const SurfaceHit& hit) {
  // Its rounding is that of the surface, which is at the same place.
  return plane_passes(hit, exact, rounding_of(hit));
}

// An apparent obstacle may be the surface that an end of the ray lies on.  That surface has the
// rounding of its vertices, while a point near zero has almost no error.
std::optional<SurfaceHit> first_other_surface(const Scene& scene, Ray ray,
                                              const EndTolerances& ends, RayFilter filter) {
  // A ray through a vertex may meet all of its triangles.  Few vertices have more than this.
  constexpr int kMostSurfaces = 16;
  // The step behind a surface at t = 0, relative to the position error and to the scene.  It keeps
  // t above the denormal numbers, which Embree treats as 0.
  constexpr double kStep = 0x1p-10, kLeast = 0x1p-90;
  constexpr float kLeastT = std::numeric_limits<float>::min();
  std::optional<SurfaceHit> hit;
  for (int i = 0; i < kMostSurfaces; ++i) {
    hit = scene.closest_hit(ray, filter);
    if (!hit) return hit;
    EndTolerance end = ends.end;
    // Its rounding is that of the surface, which is at the same place.
    if (ends.are_exact) end.error += static_cast<float>(rounding_of(*hit));
    const bool is_between = !ends.are_exact || separates(*hit, ends);
    if (is_between && !lies_on(scene, ends.start, *hit) && !lies_on(scene, end, *hit)) return hit;
    const double step_m =
        std::fmax(kStep * max_abs(hit->position_error), kLeast * largest_coordinate(scene));
    ray.t_min = std::fmax(std::fmax(std::nextafter(hit->t, INFINITY), kLeastT),
                          static_cast<float>(step_m / max_abs(ray.direction)));
    if (!(ray.t_min < ray.t_max)) return std::nullopt;
  }
  return hit;
}

bool is_blocked(const Scene& scene, const Ray& ray, const EndTolerances& ends, RayFilter blocking) {
  const Obstacle obstacle = scene.geometry().obstacle(ray, ends, blocking);
  return obstacle == Obstacle::kOther ||
         (obstacle == Obstacle::kPerhapsOwn && first_other_surface(scene, ray, ends, blocking));
}

}  // namespace lucerna

// Rays and their hits, about the scene's origin [m].  Rays are in floats, as Embree requires;
// surfaces are in double.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "lights/maths/vec.h"
#include "lights/sampling/light_sample.h"
#include "server/rays/error_bounds.h"

namespace lucerna {

enum class HitKind : std::uint8_t;  // accelerator.h

struct Ray {
  Vec3f origin;
  Vec3f direction;  ///< any length except 0; its length is the unit of t
  float t_min = 0;
  float t_max = std::numeric_limits<float>::infinity();
  double time_s = 0;  ///< has no effect if nothing moves
};

/// The end of a ray at a point that may lie on a surface with an unknown normal.
struct EndTolerance {
  Vec3 position;
  float error = -1;  ///< below 0: not such an end
};

struct EndTolerances {
  EndTolerance start, end;
  /// The positions are exact, while the ray between them is rounded.  So a surface that does not
  /// separate them is not between them, even if the ray meets it.
  bool are_exact = false;
  bool any() const { return start.error >= 0 || end.error >= 0; }
};

/// A point on a surface with all data for shading.
struct SurfaceHit {
  float t{};
  Vec3 position;
  /// Half edges of a box around `position` rounded to floats [m].  The surface passes through it,
  /// and rays find the surface within it.  For a triangle the box is narrow across the plane: the
  /// position itself is as accurate as the double precision in which the ray meets the plane.
  Vec3f position_error;
  /// Geometric normal, unit, on the outside.  In double, because floats cannot resolve on which
  /// side a grazing ray leaves the surface.
  Vec3 ng;
  /// Shading normal, unit, on the side of ng.  In double, because the error of a float would be
  /// large against the cosine of grazing light.
  Vec3 ns;
  std::uint32_t material{};         ///< index into SceneGeometry::materials()
  std::int32_t light = -1;          ///< index into Scene::lights() if the surface emits
  std::uint32_t light_primitive{};  ///< the primitive of that light's shape
  std::uint64_t shape{};            ///< the same for all hits on one shape of one instance
  double time_s = 0;                ///< time of the ray
  // Which primitive was hit, for textures: as in RawHit.
  HitKind kind{};
  std::uint32_t primitive{};
  Vec2f uv{};

  SurfacePoint on_light() const { return {position, ng, light_primitive}; }
};

/// Rays through film positions beside that of a camera ray: one in x, one in y.
struct NeighbourRays {
  Ray x, y;
};

/// std::nextafter(x, INFINITY).  A call of std::nextafter takes longer than the rest of an offset.
inline float next_up(float x) {
  if (!(x < INFINITY)) return x;
  const auto bits = std::bit_cast<std::uint32_t>(x);
  if (bits << 1 == 0) return std::bit_cast<float>(std::uint32_t{1});
  return std::bit_cast<float>(bits >> 31 == 0 ? bits + 1 : bits - 1);
}

/// `position` moved along `normal` to the side of `direction`.  The distance is just enough
/// that the ray cannot hit anything within `position_error` of the surface again.  [Pharr23,
/// 6.8.6]
inline Vec3f offset_origin(const Vec3f& position, const Vec3f& position_error, const Vec3& normal,
                           const Vec3& direction) {
  const auto moved_outwards = [](float p, float offset) {
    const float q = p + offset;
    const auto bits = std::bit_cast<std::uint32_t>(q);
    if (!(std::fabs(q) < INFINITY) || bits << 1 == 0) [[unlikely]]
      return offset > 0 ? next_up(q) : offset < 0 ? -next_up(-q) : q;
    // One ulp towards the sign of the offset.  The signs of normals are unpredictable, so branches
    // would take longer.
    const std::uint32_t towards_zero = (bits ^ std::bit_cast<std::uint32_t>(offset)) >> 31;
    const std::uint32_t moves = offset != 0 ? 1 : 0;
    return std::bit_cast<float>(bits + moves - 2 * (moves & towards_zero));
  };
  const Vec3f n(normal);
  // The extent of the error box along the normal.
  const float distance = std::fabs(n.x) * position_error.x + std::fabs(n.y) * position_error.y +
                         std::fabs(n.z) * position_error.z;
  const float signed_distance = dot(direction, normal) < 0 ? -distance : distance;
  return {moved_outwards(position.x, signed_distance * n.x),
          moved_outwards(position.y, signed_distance * n.y),
          moved_outwards(position.z, signed_distance * n.z)};
}

/// The ray that leaves a surface point towards `direction`.
inline Ray spawn_ray(const SurfaceHit& from, const Vec3f& direction) {
  Ray ray{offset_origin(Vec3f(from.position), from.position_error, from.ng, Vec3(direction)),
          direction};
  ray.time_s = from.time_s;
  return ray;
}

/// The ray whose t in (0, 1) is the open segment from a surface point to `end`, which is not on a
/// surface. `direction`: towards `end`.
inline Ray ray_to_point(const SurfaceHit& from, const Vec3& direction, const Vec3f& end) {
  const Vec3f origin = offset_origin(Vec3f(from.position), from.position_error, from.ng, direction);
  return {origin, end - origin, 0, 1, from.time_s};
}

/// The end of a shadow ray at a sampled point of a light's surface, off that surface by `error_m`
/// along each axis.  It lies on the way to the point, so that the ray keeps its direction: moved
/// along the normal, the points of a small sphere would spread.  `wi`: towards the point.
inline Vec3 before_light(const LightSample& to, const Vec3& wi, double error_m) {
  // A grazing ray would end far before the point.  It is lifted off the surface instead.
  constexpr double kLongest = 16;
  const double side = dot(to.normal, wi) < 0 ? 1 : -1;
  const double cosine = -side * dot(to.normal, wi);
  const double off_m =
      error_m * (std::fabs(to.normal.x) + std::fabs(to.normal.y) + std::fabs(to.normal.z));
  const double back_m = off_m < kLongest * off_m * cosine ? off_m / cosine : kLongest * off_m;
  return to.point - wi * back_m + to.normal * (side * (off_m - back_m * cosine));
}

/// The ray whose t in (0, 1) is the open segment from a surface point to a sampled point of a
/// light. It goes to infinity if the light is infinitely far.  Both ends are moved off their
/// surfaces. `light_reach_m`: LightMotion::reach_m.
inline Ray shadow_ray(const SurfaceHit& from, const LightSample& to, float light_reach_m = 0) {
  if (!std::isfinite(to.distance)) return spawn_ray(from, Vec3f(to.wi));
  if (to.normal == Vec3{}) return ray_to_point(from, to.wi, Vec3f(to.point));
  // The ray is rounded.  So is its test with the light's surface, whose vertices are `distance`
  // away.  For a moving light the test is in the light's own coordinates.
  const double error_m =
      kTraversalBound * (max_abs(to.point) + to.distance + double{light_reach_m}) +
      double{kLeastError};
  const Vec3f origin = offset_origin(Vec3f(from.position), from.position_error, from.ng, to.wi);
  // In double, because the rounding of a far place is large against a small light.
  const Vec3 end = before_light(to, to.wi, error_m);
  return {origin, Vec3f(end - Vec3(origin)), 0, 1, from.time_s};
}

}  // namespace lucerna

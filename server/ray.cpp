#include "server/ray.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "server/error_bounds.h"

namespace lucerna {
namespace {

/// std::nextafter(x, INFINITY), whose call takes longer than the rest of an offset.
float next_up(float x) {
  if (!(x < INFINITY)) return x;
  const auto bits = std::bit_cast<std::uint32_t>(x);
  if (bits << 1 == 0) return std::bit_cast<float>(std::uint32_t{1});
  return std::bit_cast<float>(bits >> 31 == 0 ? bits + 1 : bits - 1);
}

float moved_outwards(float p, float offset) {
  const float q = p + offset;
  if (offset > 0) return next_up(q);
  if (offset < 0) return -next_up(-q);
  return q;
}

}  // namespace

Vec3<float> offset_origin(const Vec3<float>& position, const Vec3<float>& position_error,
                          const Vec3<double>& normal, const Vec3<double>& direction) {
  const Vec3<float> n(normal);
  // The box of the error reaches this far along the normal.
  const float distance = std::fabs(n.x) * position_error.x + std::fabs(n.y) * position_error.y +
                         std::fabs(n.z) * position_error.z;
  const float signed_distance = dot(direction, normal) < 0 ? -distance : distance;
  return {moved_outwards(position.x, signed_distance * n.x),
          moved_outwards(position.y, signed_distance * n.y),
          moved_outwards(position.z, signed_distance * n.z)};
}

Ray spawn_ray(const SurfaceHit& from, const Vec3<float>& direction) {
  Ray ray{offset_origin(Vec3<float>(from.position), from.position_error, from.ng,
                        Vec3<double>(direction)),
          direction};
  ray.time_s = from.time_s;
  return ray;
}

Ray shadow_ray(const SurfaceHit& from, const LightSample<double>& to, float light_reach_m) {
  if (!std::isfinite(to.distance)) return spawn_ray(from, Vec3<float>(to.wi));
  Vec3<float> end(to.point);
  if (to.normal != Vec3<double>{}) {
    // The point itself is rounded, and so is the ray's own test against the light's surface, whose
    // vertices it sees from `distance` away; where the light moves, in coordinates of its own.
    const float error =
        kTraversalError * (max_abs(end) + static_cast<float>(to.distance) + light_reach_m) +
        kLeastError;
    end = offset_origin(end, {error, error, error}, to.normal, -to.wi);
  }
  const Vec3<float> origin =
      offset_origin(Vec3<float>(from.position), from.position_error, from.ng, to.wi);
  return {origin, end - origin, 0, 1, from.time_s};
}

}  // namespace lucerna

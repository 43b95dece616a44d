// Rays and what they find, about the scene's origin [m]: rays in floats, as Embree takes them, what
// is known of surfaces in double.
#pragma once

#include <cstdint>
#include <limits>

#include "lights/light_sample.h"
#include "lights/vec.h"

namespace lucerna {

struct Ray {
  Vec3<float> origin;
  Vec3<float> direction;  ///< any length but 0; t is in units of it
  float t_min = 0;
  float t_max = std::numeric_limits<float>::infinity();
  double time_s = 0;  ///< when: without effect where nothing moves
};

/// A point on the scene's surfaces with all that shading needs.
struct SurfaceHit {
  float t{};
  Vec3<double> position;
  /// The surface passes, and rays find it, within this box about `position` as floats hold it [m].
  Vec3<float> position_error;
  /// Geometric normal, unit, outside.  In double: which side a ray leaves to that all but grazes
  /// the surface is a sign that floats do not know.
  Vec3<double> ng;
  Vec3<float> ns;                   ///< shading normal, unit, on the side of ng
  std::uint32_t material{};         ///< index into Scene::materials()
  std::int32_t light = -1;          ///< index into Scene::lights() where the surface emits
  std::uint32_t light_primitive{};  ///< which primitive of that light's shape
  std::uint64_t shape{};            ///< the same for all hits on one shape of one instance
  double time_s = 0;                ///< of the ray that found it

  SurfacePoint<double> on_light() const { return {position, ng, light_primitive}; }
};

/// `position` moved along `normal`, to the side that `direction` leaves to, just far enough that
/// nothing within `position_error` of the surface can be hit again.  [Pharr23, 6.8.6]
Vec3<float> offset_origin(const Vec3<float>& position, const Vec3<float>& position_error,
                          const Vec3<double>& normal, const Vec3<double>& direction);

/// The ray that leaves a surface point towards `direction`.
Ray spawn_ray(const SurfaceHit& from, const Vec3<float>& direction);

/// The ray whose t in (0, 1) is the open way from a surface point to a sampled point of a light; to
/// infinity where the light is infinitely far.  Both ends are moved off their surfaces.
/// `light_reach_m`: LightMotion::reach_m.
Ray shadow_ray(const SurfaceHit& from, const LightSample<double>& to, float light_reach_m = 0);

}  // namespace lucerna

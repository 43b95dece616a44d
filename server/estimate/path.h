// Light along paths.  Each vertex samples lights and one direction of the surface.  The power
// heuristic with exponent 2 weights them against each other.  [Veach95]
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "server/estimate/direct_light.h"
#include "server/estimate/path_sample.h"
#include "server/estimate/smooth_light.h"
#include "server/scene/light_at_time.h"
#include "server/scene/scene.h"

namespace lucerna {

/// A ray for radiance queries of lights.  Unlike a traced ray, it is not rounded to floats.
struct Sight {
  Vec3 origin;
  Vec3 direction;  ///< unit
  double time_s = 0;

  Sight(const Vec3& origin, const Vec3& direction, double time_s)
      : origin(origin), direction(direction), time_s(time_s) {}
  // NOLINTNEXTLINE(google-explicit-constructor): a traced ray sees along its own floats.
  Sight(const Ray& ray) : Sight(Vec3(ray.origin), Vec3(ray.direction), ray.time_s) {}
};

/// Calls `f(light, radiance)` for each light at the ray's end: the light at `hit` or, without a
/// hit, the infinite lights.
template <typename F>
void for_each_emitter(const Scene& scene, const Sight& sight, const std::optional<SurfaceHit>& hit,
                      F&& f) {
  if (hit) {
    if (hit->light < 0) return;
    const auto light = static_cast<std::uint32_t>(hit->light);
    const Rgb le =
        LightAtTime(scene.lights()[light], sight.time_s)->le(hit->on_light(), -sight.direction);
    // `le` contains the factor alpha.  Only this share of rays meets the surface.
    if (!le.is_black()) f(light, le / scene.geometry().alpha(*hit));
    return;
  }
  for (const std::uint32_t light : scene.lights().infinite()) {
    const Rgb le =
        LightAtTime(scene.lights()[light], sight.time_s)->le_escaped(sight.origin, sight.direction);
    if (!le.is_black()) f(light, le);
  }
}

/// Immutable; may be called from any thread.
class PathTracer {
 public:
  /// `bounces`, `methods`: as in TileSettings.
  /// `candidates`: as in DirectLight.
  PathTracer(const Scene& scene, std::optional<std::uint32_t> bounces, const Methods& methods,
             std::uint32_t candidates = DirectLight::kCandidates)
      : scene_(scene),
        direct_(scene, methods, candidates),
        smooth_(scene, methods, direct_.visibility()),
        last_depth_(bounces.value_or(std::numeric_limits<std::uint32_t>::max())),
        endless_(!bounces) {}

  const DirectLight& direct() const { return direct_; }
  const SmoothLight& smooth() const { return smooth_; }
  /// The most surfaces between a vertex at this depth and a lamp.
  std::uint32_t most_steps(std::uint32_t depth) const { return last_depth_ - depth; }

  /// Radiance [cd/m2] along a ray from the camera.  `neighbours`: as in SurfaceScattering.
  LightEstimate radiance(const Ray& ray, const PathSample& sample, WorkCounts& work,
                         const NeighbourRays* neighbours = nullptr) const;

  /// Radiance [cd/m2] that the surface at `hit` reflects towards the unit vector `wo`.
  /// `depth`: number of reflections between the surface and the camera.  `before`: the vertex whose
  /// direction found the surface, if SmoothLight sampled there.
  LightEstimate reflected(const SurfaceHit& hit, const Vec3f& wo, std::uint32_t depth,
                          const PathSample& sample, WorkCounts& work,
                          SmoothLight::Before before = {},
                          const NeighbourRays* neighbours = nullptr) const;

  /// The share of light that media leave on the way along a ray to its end, or to infinity.
  Rgb left_by_media(Ray ray, const std::optional<SurfaceHit>& end) const;

  /// A direction about ns on the side of `wo`, density cos / pi.
  static Vec3f cosine_direction(const Vec3f& ns, const Vec3f& wo, Vec2f u);

 private:
  /// Number of reflections before Russian roulette begins: most light arrives with fewer.
  static constexpr std::uint32_t kSafeDepth = 2;
  /// Paths that survive the roulette have at least this weight.  With a weight of 1, a few paths
  /// carry the light of many reflections (docs/decisions/055-russian-roulette.md).
  static constexpr double kWeight = 0.3;

  struct Path;
  struct Direction;
  void add_closed_forms(Path& p) const;
  static Direction diffuse_direction(const Path& p);
  void add_samples(Path& p) const;
  static bool scatter(Path& p, Direction& next);
  bool survives(Path& p) const;
  std::optional<SurfaceHit> follow(Path& p, const Direction& next, bool finds) const;

  const Scene& scene_;
  DirectLight direct_;
  SmoothLight smooth_;
  std::uint32_t last_depth_;
  bool endless_;
};

}  // namespace lucerna

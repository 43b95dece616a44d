// Light along paths: at each vertex one light is sampled and one direction of the diffuse surface,
// both weighted against each other by the power heuristic with exponent 2.  [Veach95]
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "server/estimate/lights/direct_light.h"
#include "server/estimate/lights/path_sample.h"
#include "server/scene/scene.h"

namespace lucerna {

/// A ray as lights are asked what it finds: not rounded, unlike the ray that is traced.
struct Sight {
  Vec3<double> origin;
  Vec3<double> direction;  ///< unit
  double time_s = 0;

  Sight(const Vec3<double>& origin, const Vec3<double>& direction, double time_s)
      : origin(origin), direction(direction), time_s(time_s) {}
  // NOLINTNEXTLINE(google-explicit-constructor): a traced ray sees along its own floats.
  Sight(const Ray& ray)
      : Sight(Vec3<double>(ray.origin), Vec3<double>(ray.direction), ray.time_s) {}
};

/// Immutable; one may serve any number of threads.
class PathTracer {
 public:
  /// `bounces`, `methods`: as TileSettings has them.
  PathTracer(const Scene& scene, std::optional<std::uint32_t> bounces, const Methods& methods)
      : scene_(scene),
        direct_(scene, methods),
        last_depth_(bounces.value_or(std::numeric_limits<std::uint32_t>::max())),
        endless_(!bounces) {}

  const DirectLight& direct() const { return direct_; }

  /// Radiance [cd/m2] along a ray from the camera.
  LightEstimate radiance(const Ray& ray, const PathSample& sample, WorkCounts& work) const;

  /// Radiance [cd/m2] that the surface at `hit` reflects towards the unit vector `wo`; `depth`
  /// counts the reflections between it and the eye.
  LightEstimate reflected(const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t depth,
                          const PathSample& sample, WorkCounts& work) const;

  /// Calls `f(light, radiance)` for what is seen at the ray's end: `hit` or, where nothing was hit,
  /// the infinite lights.
  template <typename F>
  void for_each_emitter(const Sight& sight, const std::optional<SurfaceHit>& hit, F&& f) const;

  /// A direction about ns on the side of `wo`, density cos / pi.
  static Vec3<float> cosine_direction(const Vec3<float>& ns, const Vec3<float>& wo, Vec2<float> u);

 private:
  /// Reflections before Russian roulette begins: most light arrives by fewer.
  static constexpr std::uint32_t kSafeDepth = 3;

  const Scene& scene_;
  DirectLight direct_;
  std::uint32_t last_depth_;
  bool endless_;
};

template <typename F>
void PathTracer::for_each_emitter(const Sight& sight, const std::optional<SurfaceHit>& hit,
                                  F&& f) const {
  if (hit) {
    if (hit->light < 0) return;
    const auto light = static_cast<std::uint32_t>(hit->light);
    const Rgb<double> le =
        visit_light(scene_.lights()[light], sight.time_s, [&]<typename L>(const L& l) {
          if constexpr (SeenOnSurface<L>)
            return l.le(hit->on_light(), -sight.direction);
          else
            return Rgb<double>{};
        });
    if (!le.is_black()) f(light, le);
    return;
  }
  for (const std::uint32_t light : scene_.infinite_lights()) {
    const Rgb<double> le =
        visit_light(scene_.lights()[light], sight.time_s, [&]<typename L>(const L& l) {
          if constexpr (SeenBeyond<L>)
            return l.le_escaped(sight.origin, sight.direction);
          else
            return Rgb<double>{};
        });
    if (!le.is_black()) f(light, le);
  }
}

}  // namespace lucerna

// Light along paths: at each vertex one light is sampled and one direction of the diffuse surface,
// both weighted against each other by the power heuristic with exponent 2.  [Veach95]
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "lights/sobol.h"
#include "server/render.h"
#include "server/scene.h"

namespace lucerna {

/// The random numbers of one path: a point of its pixel's (or receiver's) sequence.
struct PathSample {
  const SobolSequence& sequence;
  std::uint32_t index;

  /// The j-th of n points that stand in for this one.
  PathSample part(std::uint32_t j, std::uint32_t n) const { return {sequence, index * n + j}; }

  // Pairs of dimensions, four a vertex after the camera's own.
  enum Purpose : std::uint32_t { kLight, kLightPoint, kDirection, kSurvival };
  static constexpr std::uint32_t kFilm = 0;
  /// Of the moment: drawn only where something moves.
  static constexpr std::uint32_t kTime = (1u << 30) - 1;
  /// Where many lights are visited at one receiver, each has a pair of its own from here on.
  static constexpr std::uint32_t kFirstVisited = 1u << 30;

  Vec2<float> pair(std::uint32_t dimension) const { return sequence.pair(index, dimension); }
  Vec2<float> at(std::uint32_t depth, Purpose purpose) const {
    return pair(1 + 4 * depth + purpose);
  }
};

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

/// Light of one sample, and what it would have been had every light sampled been visible.
struct LightEstimate {
  Rgb<double> value;
  Rgb<double> unshadowed;
};

/// Immutable; one may serve any number of threads.
class PathTracer {
 public:
  /// `bounces`, `methods`: as TileSettings has them.
  PathTracer(const Scene& scene, std::optional<std::uint32_t> bounces, const Methods& methods)
      : scene_(scene),
        methods_(methods),
        last_depth_(bounces.value_or(std::numeric_limits<std::uint32_t>::max())),
        endless_(!bounces) {}

  /// Radiance [cd/m2] along a ray from the camera.
  LightEstimate radiance(const Ray& ray, const PathSample& sample, WorkCounts& work) const;

  /// Radiance [cd/m2] that the surface at `hit` reflects towards the unit vector `wo`; `depth`
  /// counts the reflections between it and the eye.
  LightEstimate reflected(const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t depth,
                          const PathSample& sample, WorkCounts& work) const;

  /// One sample of `light`, chosen with `probability`: radiance [cd/m2] that a diffuse surface of
  /// reflectance 1 sends towards `wo`.  1/pi of the irradiance on the side of `wo`.
  LightEstimate direct(const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t light,
                       double probability, Vec2<float> u, WorkCounts& work) const;

  /// The same from a light that is chosen here, and which one it was.  Where there are several
  /// lights, one is taken of a few candidates by what it would send were it visible, and stands for
  /// all of them: one shadow ray.  The candidates are a sample of each light where the lights are
  /// few, else of lights chosen by power.  [Talbot05]
  struct ChosenLight {
    std::uint32_t light;
    LightEstimate estimate;
  };
  ChosenLight direct_of_chosen(const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t depth,
                               const PathSample& sample, WorkCounts& work) const;

  /// Candidates for each shadow ray where there are several lights.  With 400 point lights eight
  /// give 0.4 of the squared error of four for 1.6 times the time.
  static constexpr std::uint32_t kCandidates = 8;

  /// Whether the lights are so few that each is a candidate.
  bool visits_all() const { return scene_.lights().size() <= kCandidates; }
  /// With which `direct_of_chosen` makes a candidate of `light`.
  double candidate_probability(std::uint32_t light) const {
    return visits_all() ? 1 : scene_.light_probability(light);
  }

  /// Calls `f(light, radiance)` for what is seen at the ray's end: `hit` or, where nothing was hit,
  /// the infinite lights.
  template <typename F>
  void for_each_emitter(const Sight& sight, const std::optional<SurfaceHit>& hit, F&& f) const;

  /// The weight of light found by a direction drawn with density `direction_pdf` at `from`,
  /// where `direct`, seen from `wo`, would have chosen that light with `probability`.
  double found_weight(const SurfaceHit& from, const Vec3<float>& wo, const Ray& ray,
                      const std::optional<SurfaceHit>& hit, std::uint32_t light, double probability,
                      double direction_pdf) const;

  /// A direction about ns on the side of `wo`, density cos / pi.
  static Vec3<float> cosine_direction(const Vec3<float>& ns, const Vec3<float>& wo, Vec2<float> u);

 private:
  /// Reflections before Russian roulette begins: most light arrives by fewer.
  static constexpr std::uint32_t kSafeDepth = 3;

  /// A light sample as a diffuse surface of reflectance 1 shows it, weighted, were it visible.
  struct Candidate {
    LightSample<double> sample;
    Rgb<double> value;
  };
  Candidate candidate(const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t light,
                      double probability, Vec2<float> u) const;
  LightEstimate shadowed(const SurfaceHit& hit, std::uint32_t light,
                         const LightSample<double>& sample, const Rgb<double>& value,
                         WorkCounts& work) const;

  /// What lights are told of `hit`, in sampling and weighing alike.
  Receiver<double> receiver(const SurfaceHit& hit, const Vec3<float>& wo) const;

  const Scene& scene_;
  Methods methods_;
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

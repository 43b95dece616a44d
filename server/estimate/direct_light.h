// Direct light on a surface.  Decides which lights are sampled and with how many points.  Weights
// light samples against directions of the surface, which find lights too.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "server/estimate/light_strategy.h"
#include "server/estimate/light_visibility.h"
#include "server/estimate/methods.h"
#include "server/estimate/path_sample.h"
#include "server/estimate/surface_scattering.h"
#include "server/runtime/work_counts.h"
#include "server/scene/light_at_time.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Upper bounds of a light's illuminance, if samples choose the light with this probability.
MostIrradiance most_of(const LightAtTime& light, const Receiver& receiver, double probability);

/// Estimates the radiance [cd/m2] that a surface at `hit` sends towards `wo`.  Without a
/// SurfaceScattering the surface is diffuse with reflectance 1: 1/pi of the irradiance on the side
/// of `wo`.  Immutable; may be called from any thread.
///
/// docs/decisions/009-light-choice.md has the measurements of the constants.
class DirectLight {
 public:
  /// `candidates`: for each shadow ray, if lights are drawn by the automatic selection.
  DirectLight(const Scene& scene, const Methods& methods, std::uint32_t candidates = kCandidates);

  /// With at most this many lights, each is sampled at the vertices of paths.
  static constexpr std::size_t kFewLights = 20;
  /// Default number of candidates for each shadow ray if lights are drawn.
  static constexpr std::uint32_t kCandidates = 2;
  /// The same if all samples are one sequence.  The choice among candidates would lose its even
  /// spread.
  static constexpr std::uint32_t kCandidatesOfOneSequence = 1;
  /// If at most this many lights are not delta lights, each of these is sampled at a receiver.
  static constexpr std::size_t kFewAreas = 16;
  /// Number of delta lights that take the time of one sample of drawn lights.
  static constexpr std::uint64_t kDeltasPerSample = 12;

  /// The strategy at the vertices of paths, by the number of reflections between the vertex and
  /// the camera or receiver.
  const LightStrategy& strategy(std::uint32_t depth) const {
    return depth == 0 ? *first_ : *later_;
  }
  /// The strategy at a receiver with this number of samples.  By default, delta lights are exact if
  /// their rays do not cost more than the samples: one ray to each gives all of its direct light.
  /// The samples are then used for the other lights.
  const LightStrategy& strategy_at_receiver(std::uint64_t samples) const;
  /// From this number of samples on, delta lights are exact at a receiver.
  std::uint64_t samples_for_exact_deltas() const;
  const LightStrategy& all_lights() const { return all_; }
  /// Whether the strategy chooses among all lights, delta lights included.
  bool draws_deltas(const LightStrategy& s) const { return &s == drawn_.get(); }

  /// All light of a light that is seen in one direction from `hit`: a delta light, or a light so
  /// far away that it counts as a point.  Nothing for other lights.
  std::optional<Rgb> from_one_direction(const SurfaceHit& hit, const Vec3f& wo, std::uint32_t light,
                                        WorkCounts& work) const;
  /// Whether `from_one_direction` returns all light of every light, at any receiver.
  bool is_exact() const { return deltas_ == scene_.lights().size() && first_ == &all_; }

  /// All light of a light in closed form, if certainly nothing is in the way.  Uses no samples and
  /// no rays.  Nothing for other lights.  Requires `uses_closed_forms`.
  std::optional<Rgb> in_closed_form(const SurfaceHit& hit, const Vec3f& wo,
                                    std::uint32_t light) const;
  /// Whether closed forms are used: at receivers, or at the first vertex of paths.
  bool uses_closed_forms(bool at_receiver) const;

  /// Upper bounds of a light's illuminance at `hit`, on the side of `wo`.
  MostIrradiance most(const LightStrategy& strategy, const SurfaceHit& hit, const Vec3f& wo,
                      std::uint32_t light) const;

  const Scene& scene() const { return scene_; }
  const Methods& methods() const { return methods_; }
  bool has_deltas() const { return deltas_ > 0; }
  const Transmittance& transmittance() const { return visibility_.transmittance(); }
  const LightVisibility& visibility() const { return visibility_; }

  /// Whether directions of surfaces are sampled and may find lights.
  bool finds_lights() const {
    return methods_.combination != Combination::kLights && scene_.lights().has_visible();
  }
  /// The weight of light that a direction with density `direction_pdf` found from `from`.
  /// Samples of `strategy` with the same `wo` may choose the same light.
  double found_weight(const LightStrategy& strategy, const SurfaceHit& from, const Vec3f& wo,
                      const Ray& ray, const std::optional<SurfaceHit>& hit, std::uint32_t light,
                      double direction_pdf, const SurfaceScattering* scattering = nullptr) const;

  // For strategies.

  /// The receiver at `hit` for lights.  Samples and weights use the same receiver.
  Receiver receiver(const SurfaceHit& hit, const Vec3f& wo,
                    const SurfaceScattering* scattering = nullptr) const;
  /// A weighted light sample, scattered by the surface, without shadows.
  struct Candidate {
    LightSample sample;
    Rgb value;
    /// Upper limit of the light that a direction of the surface finds, if only directions are used.
    Rgb found;
  };
  /// `at`, `dimension`: the random numbers of the light's point.
  Candidate candidate(const LightVertex& v, const LightChoice& choice, std::uint32_t points,
                      const PathSample& at, std::uint32_t dimension) const;
  LightEstimate shadowed(const SurfaceHit& hit, std::uint32_t light, const Candidate& c,
                         WorkCounts& work) const;
  /// Samples all points of a light, and calls `v.add`.
  void sample_light(const LightVertex& v, const LightChoice& choice, const PathSample& s,
                    std::uint32_t dimension) const;

 private:
  /// The estimate of a point light at rest, with the same bits as that of other lights, in less
  /// time than a LightAtTime and its sample take.  Nothing for other lights, and where numbers
  /// overflow or underflow.  docs/decisions/016-one-point-light.md has the gain.
  std::optional<LightEstimate> from_point_light(const SurfaceHit& hit, const Vec3f& wo,
                                                const LightChoice& choice, WorkCounts& work) const;
  LightSample light_sample(const LightVertex& v, std::uint32_t light, const PathSample& at,
                           std::uint32_t dimension) const;
  /// Sets the values of a candidate at a vertex with a SurfaceScattering.
  void scatter(const LightVertex& v, const LightChoice& choice, std::uint32_t points,
               Candidate& c) const;
  /// What finds this light: only its samples, if rays do not meet it.
  Combination combination(std::uint32_t light) const;
  std::uint32_t points_on(std::uint32_t light) const;
  /// The heuristic's weight for the strategy with density `a`; the other one has density `b`.
  double weight(double a, double b) const;

  const Scene& scene_;
  Methods methods_;
  LightVisibility visibility_;
  std::size_t deltas_ = 0;
  AllLights all_;
  DeltasAndOneLight one_area_;
  std::unique_ptr<const LightStrategy> drawn_, areas_drawn_;  ///< among all lights, and areas only
  const LightStrategy *first_, *later_;  ///< at the first vertex, and after a reflection
};

}  // namespace lucerna

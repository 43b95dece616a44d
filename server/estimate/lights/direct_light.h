// Direct light on a surface.  Decides which lights are sampled and with how many points.  Weights
// light samples against directions of the surface, which find lights too.
#pragma once

#include <absl/container/inlined_vector.h>
#include <absl/functional/function_ref.h>

#include <cstdint>
#include <optional>

#include "server/estimate/lights/light_visibility.h"
#include "server/estimate/lights/methods.h"
#include "server/estimate/lights/path_sample.h"
#include "server/estimate/lights/surface_scattering.h"
#include "server/runtime/work_counts.h"
#include "server/scene/light_at_time.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Light of one sample, with and without shadows.
struct LightEstimate {
  Rgb value;
  Rgb unshadowed;

  LightEstimate& operator+=(const LightEstimate& e) {
    value += e.value;
    unshadowed += e.unshadowed;
    return *this;
  }
};

/// A set of light indices.
class LightSet {
 public:
  bool has(std::uint32_t light) const {
    return light / 64 < bits_.size() && (bits_[light / 64] >> light % 64 & 1) != 0;
  }
  void add(std::uint32_t light) {
    if (light / 64 >= bits_.size()) bits_.resize(light / 64 + 1);
    bits_[light / 64] |= std::uint64_t{1} << light % 64;
  }
  void clear() { bits_.clear(); }

 private:
  absl::InlinedVector<std::uint64_t, 1> bits_;  // every receiver has a set
};

/// How the samples of a vertex are distributed over the lights.
enum class Spending {
  /// Samples points on each light, each with a shadow ray.
  kEach,
  /// Samples points on lights that a LightSelector chooses.  One of several candidates is
  /// chosen by its unshadowed contribution and represents all of them, with one shadow ray.
  /// [Talbot05]
  kDrawn,
  /// As kDrawn, for all lights except delta lights.
  kAreasDrawn,
  /// As kEach for delta lights.  Samples points on one of the other lights, which the light tree
  /// chooses.
  kOneArea,
};

/// Upper bounds of a light's illuminance, if samples choose the light with this probability.
MostIrradiance most_of(const LightAtTime& light, const Receiver& receiver, double probability);

/// Estimates the radiance [cd/m2] that a surface at `hit` sends towards `wo`.  Without a
/// SurfaceScattering the surface is diffuse with reflectance 1: 1/pi of the irradiance on the side
/// of `wo`.  Immutable; may be called from any thread.
class DirectLight {
 public:
  /// `candidates`: for each shadow ray, if lights are drawn by the automatic selection.
  DirectLight(const Scene& scene, const Methods& methods, std::uint32_t candidates = kCandidates);

  /// With at most this many lights, each is sampled at the vertices of paths.  Measured: squared
  /// error times time of pictures, relative to drawn candidates.
  ///
  /// tests/data/reference/many_points.pbrt, up to five bounces: 0.7, 0.8, 1.8 and 8 for the
  /// first 16, 24, 64 and all 400 points.
  ///
  /// many_triangles.pbrt: 0.6 and 1.7 for the first 24 and 64 lights.
  ///
  /// 0.6 for the four lights of scenes/demo.pbrt, 0.8 for the 17 of scenes/stage, 1.2 for the
  /// ten of scenes/room.
  static constexpr std::size_t kFewLights = 20;
  /// Default number of candidates for each shadow ray if lights are drawn.  Measured: squared error
  /// times time of one, four and eight candidates, relative to two.
  ///
  /// 1.1, 1.7 and 2.8 in pictures of many_points.pbrt; 0.9, 1.3 and 2.3 of
  /// many_triangles.pbrt; 1.1, 1.2 and 1.7 of scenes/street.
  ///
  /// At receivers of the street: 1.8 to 3.2, 0.8 to 1.0 and 0.8 to 1.1.
  static constexpr std::uint32_t kCandidates = 2;
  /// The same if all samples are one sequence.  The choice among candidates would lose its even
  /// spread.  Measured: squared error times time of two candidates, relative to one, is 1.5 in
  /// many_points.pbrt and in many_triangles.pbrt.
  static constexpr std::uint32_t kCandidatesOfOneSequence = 1;
  /// If at most this many lights are not delta lights, each of these is sampled at a receiver.
  static constexpr std::size_t kFewAreas = 16;
  /// Number of delta lights that take the time of one sample of drawn lights.
  static constexpr std::uint64_t kSettledPerSample = 12;

  /// The distribution at the vertices of paths, by the number of reflections between the vertex and
  /// the camera or receiver.
  Spending spending(std::uint32_t depth) const { return depth == 0 ? spending_ : later_spending_; }
  /// The distribution at a receiver with this number of samples.  By default, delta lights are
  /// settled if this does not cost more than the samples: one ray to each of them gives all of its
  /// direct light.  The samples are then used for the other lights.
  Spending spending_at_receiver(std::uint64_t samples) const;
  /// From this number of samples on, delta lights are settled at a receiver.
  std::uint64_t settling_samples() const;

  /// Called for each light that was sampled.  The estimates of one call of `sample` add up to
  /// an estimate of all light.
  using Found = absl::FunctionRef<void(std::uint32_t light, const LightEstimate&)>;
  /// Samples the lights that are not in `settled`.
  void sample(Spending spending, const SurfaceHit& hit, const Vec3f& wo, std::uint32_t depth,
              const PathSample& s, const LightSet& settled, WorkCounts& work, const Found& found,
              const SurfaceScattering* scattering = nullptr) const;

  /// All light of a light that is seen in one direction from `hit`: a delta light, or a light so
  /// far away that it counts as a point.  Nothing for other lights.
  std::optional<Rgb> from_one_direction(const SurfaceHit& hit, const Vec3f& wo, std::uint32_t light,
                                        WorkCounts& work) const;

  /// Whether `from_one_direction` returns all light of every light, at any receiver.
  bool is_exact() const {
    return deltas_ == scene_.lights().size() && spending_ == Spending::kEach;
  }

  /// All light of a light in closed form, if certainly nothing is in the way.  Uses no samples and
  /// no rays.  Nothing for other lights.  Requires `uses_closed_forms`.
  std::optional<Rgb> in_closed_form(const SurfaceHit& hit, const Vec3f& wo,
                                    std::uint32_t light) const;
  /// Whether closed forms are used: at receivers, or at the first vertex of paths.
  bool uses_closed_forms(bool at_receiver) const;

  /// Upper bounds of a light's illuminance at `hit`, on the side of `wo`.
  MostIrradiance most(Spending spending, const SurfaceHit& hit, const Vec3f& wo,
                      std::uint32_t light) const;

  const Transmittance& transmittance() const { return visibility_.transmittance(); }
  const LightVisibility& visibility() const { return visibility_; }

  /// Whether directions of surfaces are sampled and may find lights.
  bool finds_lights() const {
    return methods_.combination != Combination::kLights && scene_.has_visible_lights();
  }
  /// The weight of light that a direction with density `direction_pdf` found from `from`.
  /// `sample` with the same `spending` and `wo` may choose the same light.
  double found_weight(Spending spending, const SurfaceHit& from, const Vec3f& wo, const Ray& ray,
                      const std::optional<SurfaceHit>& hit, std::uint32_t light,
                      double direction_pdf, const SurfaceScattering* scattering = nullptr) const;

 private:
  /// A weighted light sample, scattered by the surface, without shadows.
  struct Candidate {
    LightSample sample;
    Rgb value;
    /// Upper limit of the light that a direction of the surface finds, if only directions are used.
    Rgb found;
  };

  /// The arguments of `sample` at one vertex.
  struct Vertex {
    const SurfaceHit& hit;
    const Vec3f& wo;
    std::uint32_t depth;
    const LightSet& settled;
    WorkCounts& work;
    const Found& found;
    const SurfaceScattering* scattering;
  };
  void sample_points(const Vertex& v, const LightChoice& choice, const PathSample& s,
                     std::uint32_t dimension) const;
  void sample_one_of(const Vertex& v, Spending spending, const PathSample& s, double share) const;

  /// `at`, `dimension`: the random numbers of the light's point.
  LightSample light_sample(const Vertex& v, std::uint32_t light, const PathSample& at,
                           std::uint32_t dimension) const;
  Candidate candidate(const Vertex& v, const LightChoice& choice, std::uint32_t points,
                      const PathSample& at, std::uint32_t dimension) const;
  /// Sets the values of a candidate at a vertex with a SurfaceScattering.
  void scatter(const Vertex& v, const LightChoice& choice, std::uint32_t points,
               Candidate& c) const;
  LightEstimate shadowed(const SurfaceHit& hit, std::uint32_t light, const LightSample& sample,
                         const Rgb& value, WorkCounts& work) const;
  /// The estimate of a point light at rest, with the same bits as that of other lights, in less
  /// time than a LightAtTime and its sample take.  Nothing for other lights, and where numbers
  /// overflow or underflow.  docs/decisions/016-one-point-light.md has the gain.
  std::optional<LightEstimate> from_point_light(const SurfaceHit& hit, const Vec3f& wo,
                                                const LightChoice& choice, WorkCounts& work) const;
  bool is_delta(std::uint32_t light) const;
  /// What finds this light: only its samples, if rays do not meet it.
  Combination combination(std::uint32_t light) const;
  const LightSelector& selector(Spending spending) const;
  std::uint32_t points_on(std::uint32_t light) const;
  /// The heuristic's weight for the strategy with density `a`; the other one has density `b`.
  double weight(double a, double b) const;

  /// The receiver at `hit` for lights.  Samples and weights use the same receiver.
  Receiver receiver(const SurfaceHit& hit, const Vec3f& wo,
                    const SurfaceScattering* scattering = nullptr) const;

  const Scene& scene_;
  Methods methods_;
  LightVisibility visibility_;
  Spending spending_;
  Spending later_spending_;  ///< after a reflection
  std::size_t deltas_ = 0;
  std::uint32_t candidates_ = 1;
};

}  // namespace lucerna

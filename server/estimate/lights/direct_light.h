// Light that comes to a surface straight from lights: which of them are sampled, by how many
// points, and how their samples are weighed against directions of the surface that find lights too.
#pragma once

#include <absl/container/inlined_vector.h>
#include <absl/functional/function_ref.h>

#include <cstdint>
#include <optional>

#include "server/estimate/lights/light_visibility.h"
#include "server/estimate/lights/methods.h"
#include "server/estimate/lights/path_sample.h"
#include "server/runtime/work_counts.h"
#include "server/scene/scene.h"

namespace lucerna {

/// Light of one sample, and what it would have been had every light sampled been visible.
struct LightEstimate {
  Rgb<double> value;
  Rgb<double> unshadowed;

  LightEstimate& operator+=(const LightEstimate& e) {
    value += e.value;
    unshadowed += e.unshadowed;
    return *this;
  }
};

/// Lights by index.
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

/// How the samples of a vertex are spent on several lights.
enum class Spending {
  /// Points on each of them, each with a shadow ray.
  kEach,
  /// Points on lights that are drawn by a LightSelector: one light, or of several candidates one,
  /// which is taken by what it would send were it visible and stands for all: one shadow ray.
  /// [Talbot05]
  kDrawn,
  /// The same of all lights but delta lights.
  kAreasDrawn,
};

/// All estimates are of the radiance [cd/m2] that a diffuse surface of reflectance 1 at `hit` sends
/// towards `wo`: 1/pi of the irradiance on that side.  Immutable; one may serve any number of
/// threads.
class DirectLight {
 public:
  DirectLight(const Scene& scene, const Methods& methods);

  /// Up to so many lights are sampled each at the vertices of paths.  Squared error times time of
  /// pictures, as a multiple of that of candidates that are drawn: 0.7, 0.8, 1.8 and 8 for the
  /// first 16, 24, 64 and all 400 points of tests/data/reference/many_points.pbrt where light is
  /// scattered up to five times, 0.6 and 1.7 for the first 24 and 64 of many_triangles.pbrt as it
  /// is; 0.6 for the four lights of scenes/demo.pbrt, 0.8 for the 17 of scenes/stage, 1.2 for the
  /// ten of scenes/room.
  static constexpr std::size_t kFewLights = 20;
  /// Candidates for each shadow ray where lights are drawn and nobody said how.  Squared error
  /// times time, as a multiple of that of two, of one, four and eight: 1.1, 1.7 and 2.8 in pictures
  /// of many_points.pbrt, 0.9, 1.3 and 2.3 of many_triangles.pbrt, 1.1, 1.2 and 1.7 of
  /// scenes/street; at receivers of the street 1.8 to 3.2, 0.8 to 1.0 and 0.8 to 1.1.
  static constexpr std::uint32_t kCandidates = 2;
  /// Up to so many lights that are not delta lights are sampled each at a receiver.
  static constexpr std::size_t kFewAreas = 16;
  /// Delta lights that are settled in the time of one sample of drawn lights.
  static constexpr std::uint64_t kSettledPerSample = 12;

  /// At the vertices of paths.
  Spending spending() const { return spending_; }
  /// At a receiver that so many samples are taken at.  Unless something else was asked for, delta
  /// lights are settled by a ray each where that costs no more than the samples, and samples are
  /// spent on the others alone.
  Spending spending_at_receiver(std::uint64_t samples) const;
  /// So many samples settle delta lights at a receiver.
  std::uint64_t settling_samples() const;

  /// Told of each light that was sampled; all estimates of one call add up to one of all light.
  using Found = absl::FunctionRef<void(std::uint32_t light, const LightEstimate&)>;
  /// Samples lights but those of `settled`.
  void sample(Spending spending, const SurfaceHit& hit, const Vec3<float>& wo, std::uint32_t depth,
              const PathSample& s, const LightSet& settled, WorkCounts& work, Found found) const;

  /// All light of a light that is seen in one direction from `hit`: of a delta light, or one that
  /// is far enough to count as one.  Nothing of others.
  std::optional<Rgb<double>> of_one_direction(const SurfaceHit& hit, const Vec3<float>& wo,
                                              std::uint32_t light, WorkCounts& work) const;

  /// Whether `of_one_direction` says all of every light, at any receiver.
  bool settles_all() const {
    return deltas_ == scene_.lights().size() && spending_ == Spending::kEach;
  }

  /// All light of a light that is known without sampling and without a ray: in closed form, where
  /// nothing is in the way for certain.  Nothing of others.  Requires `uses_closed_forms`.
  std::optional<Rgb<double>> in_closed_form(const SurfaceHit& hit, const Vec3<float>& wo,
                                            std::uint32_t light) const;
  /// Whether those are wanted, at receivers or at the first vertex of paths.
  bool uses_closed_forms(bool at_receiver) const;

  /// Whether directions of surfaces may find lights that count.
  bool finds_lights() const {
    return methods_.combination != Combination::kLights && scene_.has_visible_lights();
  }
  /// The weight of light found by a direction drawn with density `direction_pdf` at `from`, where
  /// `sample` with the same `spending`, seen from `wo`, might have found it too.
  double found_weight(Spending spending, const SurfaceHit& from, const Vec3<float>& wo,
                      const Ray& ray, const std::optional<SurfaceHit>& hit, std::uint32_t light,
                      double direction_pdf) const;

 private:
  /// A light sample as a diffuse surface of reflectance 1 shows it, weighted, were it visible.
  struct Candidate {
    LightSample<double> sample;
    Rgb<double> value;
    /// What a direction of the surface finds at most where only those count.
    Rgb<double> found;
  };

  /// What a vertex is sampled with.
  struct Vertex {
    const SurfaceHit& hit;
    const Vec3<float>& wo;
    std::uint32_t depth;
    const LightSet& settled;
    WorkCounts& work;
    Found found;
  };
  void sample_points(const Vertex& v, const LightChoice& choice, const PathSample& s,
                     std::uint32_t dimension) const;
  void sample_one_of(const Vertex& v, Spending spending, const PathSample& s, double share) const;

  Candidate candidate(const SurfaceHit& hit, const Vec3<float>& wo, const LightChoice& choice,
                      std::uint32_t points, Vec2<float> u) const;
  LightEstimate shadowed(const SurfaceHit& hit, std::uint32_t light,
                         const LightSample<double>& sample, const Rgb<double>& value,
                         WorkCounts& work) const;
  bool is_delta(std::uint32_t light) const;
  const LightSelector& selector(Spending spending) const;
  std::uint32_t points_on(std::uint32_t light) const;
  /// The heuristic's weight of the strategy with density `a` against `b`.
  double weight(double a, double b) const;

  /// What lights are told of `hit`, in sampling and weighing alike.
  Receiver<double> receiver(const SurfaceHit& hit, const Vec3<float>& wo) const;

  const Scene& scene_;
  Methods methods_;
  LightVisibility visibility_;
  Spending spending_;
  std::size_t deltas_ = 0;
  std::uint32_t candidates_ = 1;
};

}  // namespace lucerna

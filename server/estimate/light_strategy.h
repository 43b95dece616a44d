// Strategies of direct light: which lights a vertex samples, and with what probability.
#pragma once

#include <absl/container/inlined_vector.h>
#include <absl/functional/function_ref.h>

#include <cstdint>
#include <optional>

#include "server/estimate/path_sample.h"
#include "server/estimate/surface_scattering.h"
#include "server/runtime/work_counts.h"
#include "server/scene/light_selector.h"
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

/// Called for each light that was sampled.  The estimates of one sample add up to an estimate of
/// all light.
using AddLight = absl::FunctionRef<void(std::uint32_t light, const LightEstimate&)>;

/// A vertex of a path, or a receiver, whose direct light is sampled.
struct LightVertex {
  const SurfaceHit& hit;
  const Vec3f& wo;
  std::uint32_t depth;    ///< reflections between the vertex and the camera or receiver
  const LightSet& exact;  ///< lights that are not sampled
  WorkCounts& work;
  AddLight add;
  const SurfaceScattering* scattering = nullptr;  ///< null: diffuse with reflectance 1
};

class DirectLight;

/// Chooses the lights that a vertex samples.  Immutable; may be called from any thread.
class LightStrategy {
 public:
  virtual ~LightStrategy() = default;
  virtual void sample(const DirectLight& direct, const LightVertex& v,
                      const PathSample& s) const = 0;
  /// The probability with which `sample` chooses the light.
  virtual double probability(const Scene& scene, const Receiver& receiver,
                             std::uint32_t light) const = 0;
  /// Whether a chosen light has all of its points (DirectLight::points_on), rather than one.
  virtual bool takes_all_points() const { return true; }
};

/// Samples each light, with a shadow ray for each point.
class AllLights final : public LightStrategy {
 public:
  void sample(const DirectLight& direct, const LightVertex& v, const PathSample& s) const override;
  double probability(const Scene&, const Receiver&, std::uint32_t) const override { return 1; }
};

/// Samples one light, chosen uniformly, by power or by the light BVH [Conty18].
class OneLight : public LightStrategy {
 public:
  /// `areas_only`: no delta light is chosen.
  OneLight(LightSelection how, bool areas_only) : how_(how), areas_only_(areas_only) {}

  void sample(const DirectLight& direct, const LightVertex& v, const PathSample& s) const override;
  double probability(const Scene& scene, const Receiver& receiver,
                     std::uint32_t light) const override;
  std::optional<LightChoice> choose(const Scene& scene, const Receiver& receiver, double u) const;

 private:
  LightSelection how_;
  bool areas_only_;
};

/// Chooses candidates as OneLight does.  One of them, drawn by its unshadowed contribution,
/// represents all of them, with one shadow ray.  [Talbot05]
class ResampledLights final : public OneLight {
 public:
  ResampledLights(LightSelection how, bool areas_only, std::uint32_t candidates)
      : OneLight(how, areas_only), candidates_(candidates) {}

  void sample(const DirectLight& direct, const LightVertex& v, const PathSample& s) const override;
  bool takes_all_points() const override { return false; }

 private:
  void sample_one_of(const DirectLight& direct, const LightVertex& v, const PathSample& s,
                     double share) const;

  std::uint32_t candidates_;
};

/// Samples each delta light, and one of the other lights, chosen by the light BVH.
class DeltasAndOneLight final : public LightStrategy {
 public:
  void sample(const DirectLight& direct, const LightVertex& v, const PathSample& s) const override;
  /// Of a light that is no delta light.
  double probability(const Scene& scene, const Receiver& receiver,
                     std::uint32_t light) const override {
    return other_.probability(scene, receiver, light);
  }

 private:
  OneLight other_{LightSelection::kBvh, true};
};

}  // namespace lucerna

// The part of a receiver's light that needs no samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/estimate/lamp_rays.h"
#include "server/estimate/path.h"
#include "server/queries/irradiance_estimate.h"
#include "server/queries/receiver_irradiance.h"

namespace lucerna {

/// The exact part of the light at a receiver, and how the rest is sampled.
struct ExactPart {
  Rgb lx;
  LightSet lights{};        // their direct light is part of it
  std::vector<Rgb> shares;  // of each light, with `per_light` [lx]
  BySpectrum by_spectrum;
  // Of the rest.
  const LightStrategy* strategy;
  bool needs_samples = false;
  bool gathers = false;  // samples directions of the receiver too
  GuidedDirections guided{};
};

/// Immutable; may be called from any thread.
class ExactLight {
 public:
  /// Closed forms and shafts take as long as this many samples.
  static constexpr std::uint64_t kSamplesPerShafts = 4;

  /// All must outlive it.  `gathers`: light that surfaces reflect is part of the answer.
  ExactLight(const Scene& scene, const IrradianceSettings& settings, const PathTracer& tracer,
             bool gathers);

  /// Of a point that will take this many samples: lights of one direction, unless they are drawn,
  /// and lights in closed form.
  ExactPart at(const SurfaceHit& receiver, std::uint64_t samples, WorkCounts& work) const;
  const LightStrategy& strategy(std::uint64_t samples) const {
    return settings_.per_light ? direct_.all_lights() : direct_.strategy_at_receiver(samples);
  }

  /// Sums by the spectra of lights; unused without wavelengths.
  BySpectrum no_spectra() const {
    return BySpectrum(settings_.wavelengths_nm.empty() ? 0 : scene_.lights().spectra().size() + 1);
  }
  void add_to(BySpectrum& groups, std::uint32_t light, const Rgb& lx) const {
    if (!groups.wanted()) return;
    const auto number = scene_.lights().spectrum_number(light);
    groups.add(number ? *number + 1 : 0, lx);
  }

 private:
  bool uses_closed_forms(std::uint64_t samples) const;

  const Scene& scene_;
  const IrradianceSettings& settings_;
  const PathTracer& tracer_;
  const DirectLight& direct_;
  const bool gathers_;
  const std::span<const LampRay> lamp_rays_;
};

}  // namespace lucerna

#include "server/estimate/queries/settled_light.h"

#include <numbers>
#include <optional>

namespace lucerna {

LightSettler::LightSettler(const Scene& scene, const IrradianceSettings& settings,
                           const PathTracer& tracer, bool gathers)
    : scene_(scene),
      settings_(settings),
      tracer_(tracer),
      direct_(tracer.direct()),
      gathers_(gathers),
      lamp_rays_(gathers && direct_.finds_lights() ? lamp_rays(scene)
                                                   : std::span<const LampRay>()) {}

Settled LightSettler::settle(const SurfaceHit& receiver, std::uint64_t samples,
                             WorkCounts& work) const {
  Settled s{.exact = {},
            .shares = std::vector<Rgb>(settings_.per_light ? scene_.lights().size() : 0),
            .by_spectrum = no_spectra(),
            .spending = spending(samples)};
  s.needs_samples = !settle_lights(receiver, samples, s, work) || gathers_;
  s.gathers = gathers_ || (direct_.finds_lights() && s.needs_samples);
  if (!lamp_rays_.empty()) s.guided = GuidedDirections(lamp_rays_, receiver.position, receiver.ns);
  if (gathers_ && direct_.finds_lights()) tracer_.smooth().guide(receiver, s.guided);
  return s;
}

/// Closed forms do not pay if there are few samples and reflected light has an error anyway.
bool LightSettler::uses_closed_forms(std::uint64_t samples) const {
  if (!direct_.uses_closed_forms(true)) return false;
  return settings_.methods.closed_forms != ClosedForms::kAutomatic || !gathers_ ||
         samples >= kSamplesPerShafts;
}

/// Returns false if lights remain.
bool LightSettler::settle_lights(const SurfaceHit& receiver, std::uint64_t samples, Settled& to,
                                 WorkCounts& work) const {
  const Vec3f n(receiver.ns);
  const bool closed_forms = uses_closed_forms(samples);
  bool all_settled = true;
  for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
    std::optional<Rgb> all;
    if (to.spending == Spending::kEach || to.spending == Spending::kAreasDrawn)
      all = direct_.from_one_direction(receiver, n, l, work);
    if (!all && closed_forms) all = direct_.in_closed_form(receiver, n, l);
    if (all) {
      const Rgb lx = *all * std::numbers::pi;
      to.lights.add(l);
      to.exact += lx;
      add_to(to.by_spectrum, l, lx);
      if (!to.shares.empty()) to.shares[l] = lx;
    } else {
      all_settled = false;
    }
  }
  return all_settled;
}

}  // namespace lucerna

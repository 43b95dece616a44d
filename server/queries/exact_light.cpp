#include "server/queries/exact_light.h"

#include <numbers>
#include <optional>

namespace lucerna {

ExactLight::ExactLight(const Scene& scene, const IrradianceSettings& settings,
                       const PathTracer& tracer, bool gathers)
    : scene_(scene),
      settings_(settings),
      tracer_(tracer),
      direct_(tracer.direct()),
      gathers_(gathers),
      lamp_rays_(gathers && direct_.finds_lights() ? lamp_rays(scene)
                                                   : std::span<const LampRay>()) {}

/// Closed forms do not pay if there are few samples and reflected light has an error anyway.
bool ExactLight::uses_closed_forms(std::uint64_t samples) const {
  if (!direct_.uses_closed_forms(true)) return false;
  return settings_.methods.closed_forms != ClosedForms::kAutomatic || !gathers_ ||
         samples >= kSamplesPerShafts;
}

ExactPart ExactLight::at(const SurfaceHit& receiver, std::uint64_t samples,
                         WorkCounts& work) const {
  ExactPart part{.lx = {},
                 .shares = std::vector<Rgb>(settings_.per_light ? scene_.lights().size() : 0),
                 .by_spectrum = no_spectra(),
                 .strategy = &strategy(samples),
                 .needs_samples = gathers_};
  const Vec3f n(receiver.ns);
  const bool closed_forms = uses_closed_forms(samples);
  for (std::uint32_t l = 0; l < scene_.lights().size(); ++l) {
    std::optional<Rgb> all;
    if (!direct_.draws_deltas(*part.strategy))
      all = direct_.from_one_direction(receiver, n, l, work);
    if (!all && closed_forms) all = direct_.in_closed_form(receiver, n, l);
    if (!all) {
      part.needs_samples = true;
      continue;
    }
    const Rgb lx = *all * std::numbers::pi;
    part.lights.add(l);
    part.lx += lx;
    add_to(part.by_spectrum, l, lx);
    if (!part.shares.empty()) part.shares[l] = lx;
  }
  part.gathers = gathers_ || (direct_.finds_lights() && part.needs_samples);
  if (!lamp_rays_.empty())
    part.guided = GuidedDirections(lamp_rays_, receiver.position, receiver.ns);
  if (gathers_ && direct_.finds_lights()) tracer_.smooth().guide(receiver, part.guided);
  return part;
}

}  // namespace lucerna

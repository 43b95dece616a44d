#include "server/estimate/queries/predicted_time.h"

#include <algorithm>

#include "server/scene/scene_lights.h"
#include "server/shadows/shadow_maps.h"

namespace lucerna {
namespace {

// Time of one item [s].
constexpr double kLeSeconds = 1.5e-6;
constexpr double kEmissionSeconds = 500e-9;
constexpr double kPdfSeconds = 200e-9;
constexpr double kPdfPrimitiveSeconds = 20e-9;
constexpr double kLightSampleSeconds = 400e-9;
constexpr double kSampleShadowRaySeconds = 1e-6;
constexpr double kVisibilitySeconds = 1.5e-6;
constexpr double kPowerSeconds = 300e-9;
constexpr double kPowerRaySeconds = 300e-9;
constexpr double kDirectSampleSeconds = 2e-6;
constexpr double kPathSampleSeconds = 8e-6;
constexpr double kSpectrumSeconds = 200e-9;  // a spectrum at a wavelength
// Time to make the shafts of a scene, at first use.
constexpr double kShaftsSeconds = 1e-3;
// Lights that a sample of irradiance visits, unless each light has its own share.
constexpr double kVisitedLights = 8;

double each(std::size_t items, double seconds) { return static_cast<double>(items) * seconds; }

}  // namespace

double le_seconds(std::size_t rays, std::size_t wavelengths) {
  return each(rays, kLeSeconds + each(wavelengths, kWavelengthSeconds));
}

double sample_le_seconds(std::size_t rays, std::size_t wavelengths) {
  return each(rays, kEmissionSeconds + each(wavelengths, kWavelengthSeconds));
}

double pdf_seconds(const Light& light, std::size_t items) {
  return each(items,
              kPdfSeconds + kPdfPrimitiveSeconds * static_cast<double>(primitive_count(light)));
}

double sample_li_seconds(const SampleLiQuery& query, double samples) {
  return samples * (kLightSampleSeconds + (query.test_visibility ? kSampleShadowRaySeconds : 0) +
                    each(query.wavelengths_nm.size(), kWavelengthSeconds));
}

double visibility_seconds(std::size_t items) { return each(items, kVisibilitySeconds); }

double power_seconds(std::size_t lights, std::size_t wavelengths) {
  return each(lights, kPowerSeconds + each(wavelengths, kWavelengthSeconds));
}

double sampled_power_seconds(std::size_t lights, std::uint64_t samples) {
  return each(lights, static_cast<double>(samples) * kPowerRaySeconds);
}

double irradiance_samples_seconds(const Scene& scene, const IrradianceSettings& settings,
                                  std::size_t points, std::uint64_t samples) {
  const bool direct = settings.bounces == 0U;
  const double lights =
      settings.per_light ? static_cast<double>(scene.lights().size()) : kVisitedLights;
  return each(points, static_cast<double>(samples) *
                          (direct ? kDirectSampleSeconds : kPathSampleSeconds) *
                          std::max(1.0, lights));
}

double irradiance_fixed_seconds(const Scene& scene, const IrradianceSettings& settings,
                                std::size_t points) {
  // Each spectrum is looked up once at each wavelength, and has a value there at each point.
  const std::size_t spectra = scene.spectra().size() + 1;
  double seconds = first_use_seconds(scene, settings.methods) +
                   each(spectra * settings.wavelengths_nm.size(),
                        kSpectrumSeconds + each(points, kWavelengthSeconds));
  // With this time, a thread of gRPC does not make the shafts.
  if (scene.has_visible_lights() && settings.methods.closed_forms != ClosedForms::kOff)
    seconds += kShaftsSeconds;
  return seconds;
}

double first_use_seconds(const Scene& scene, const Methods& methods) {
  return methods.visibility == VisibilityMethod::kShadowMaps ? shadow_maps(scene).seconds_left()
                                                             : 0;
}

}  // namespace lucerna

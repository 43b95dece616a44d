// Indices of refraction of metals and glasses, by name or from spectra.
#pragma once

#include <optional>
#include <string_view>

#include "lights/maths/spectrum.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The spectrum that a name such as "metal-Cu-eta" or "metal-Cu-k" means: a metal's index, from 360
/// to 830 nm.  Nothing for other names.  Silver, aluminium, gold, chromium, copper and tungsten
/// (Ag Al Au Cr Cu W), measured.  [Palik85]
std::optional<SampledSpectrum> metal_spectrum(std::string_view name);

struct MetalIndex {
  Rgb eta, k;
};

/// The index of a metal in RGB, from the spectra of two parameters; null for those of copper.  eta
/// is the mean of the spectrum in each channel under D65.  k gives the channel the reflectance at
/// normal incidence that the spectra have under D65.  Nothing if a parameter is no spectrum.
std::optional<MetalIndex> metal_index(LoadState& context, const Parameter* eta, const Parameter* k);

/// The RGB of a spectrum, as the colour of a surface under D65.
Rgb under_d65(const SampledSpectrum& spectrum);

/// The index of a dielectric at 589.3 nm, from a spectrum or a glass that pbrt-v4 names.  With a
/// remark, since dispersion is not modelled.
double index_at_sodium(LoadState& context, const Parameter& parameter);

}  // namespace lucerna::pbrt

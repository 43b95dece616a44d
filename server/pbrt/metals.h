// Indices of refraction of metals and glasses, by name or from spectra.
#pragma once

#include <optional>

#include "lights/maths/spectrum.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

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

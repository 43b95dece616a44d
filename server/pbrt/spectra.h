// Spectra that scene files give: of lights as they are, of surfaces as linear RGB.
#pragma once

#include <memory>

#include "lights/spectra/rgb.h"
#include "lights/spectra/spectrum.h"
#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// The spectrum that a light's parameter `name` gives: a black body, samples, a file of samples
/// ("wavelength value" pairs, # begins a comment) or a CIE illuminant ("stdillum-A").  Null where
/// it is an rgb, where it is not given, and, with a remark, for named spectra of metals, glasses
/// and cameras and for spectra of which the eye sees nothing.  Lights that say the same share it.
std::shared_ptr<const Spectrum> light_spectrum(Context& context, const ParameterSet& params,
                                               std::string_view name);

/// Says of a light with a picture, whose colours are RGB, that a spectrum in `name` is taken as
/// RGB.
void remark_on_spectrum_of_picture(Context& context, const ParameterSet& params,
                                   std::string_view name);

/// The level that a light's parameter `name` gives, before `scale`: the channels of an rgb as they
/// are, spectra at luminance 1, black where the eye sees nothing of them, white of luminance 1
/// where it is not given.  Fails on negative values.
Rgb<double> light_level(Context& context, const ParameterSet& params, std::string_view name);

/// What a reflectance parameter (rgb, spectrum, float) says, each channel clamped to [0, 1].
/// Textures are the caller's.
Rgb<double> reflectance(Context& context, const Parameter& parameter);

}  // namespace lucerna::pbrt

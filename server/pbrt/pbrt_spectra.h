// Spectra in scene files: kept for lights, converted to linear RGB for surfaces.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "lights/maths/rgb.h"
#include "lights/maths/spectrum.h"
#include "server/pbrt/pbrt_params.h"

namespace lucerna::pbrt {

/// The spectrum that a light's parameter `name` gives: a black body, samples, a file of samples
/// ("wavelength value" pairs, # begins a comment) or a CIE illuminant ("stdillum-A").  Lights with
/// the same spectrum share it.  Null for an rgb, or if it is not given.  Null, with a remark, for
/// named spectra of metals, glasses and cameras, and for spectra outside of the visible range.
std::shared_ptr<const Spectrum> light_spectrum(LoadState& context, const ParameterSet& params,
                                               std::string_view name);

/// Adds a remark that a spectrum in `name` is converted to RGB.  For lights with pictures, whose
/// colours are RGB.
void remark_on_spectrum_of_picture(LoadState& context, const ParameterSet& params,
                                   std::string_view name);

/// The level that a light's parameter `name` gives, before `scale`: the channels of an rgb, or a
/// spectrum at luminance 1.  Black for an invisible spectrum; white of luminance 1 if it is not
/// given.  Fails on negative values.
Rgb light_level(LoadState& context, const ParameterSet& params, std::string_view name);

/// The values of an rgb, converted to Rec. 709 from the colour space of the file.  A colour outside
/// of Rec. 709 becomes the one at its edge of the same luminance, with a remark.  Fails on negative
/// values.
Rgb not_negative_rgb(LoadState& context, const Parameter& parameter, RgbConversion::White white);

/// The samples that a parameter of type spectrum gives, itself or in a file it names.  Fails on
/// other names.
SampledSpectrum spectrum_samples(LoadState& context, const Parameter& parameter);

/// The reflectance of a parameter (rgb, spectrum, float), each channel clamped to [0, 1] with a
/// remark.  A spectrum becomes its colour under D65.  Grey, with a remark, for named spectra, none
/// of which is a reflectance.  The caller handles textures.
Rgb reflectance(LoadState& context, const Parameter& parameter);

/// Whether all samples have one value.
bool is_constant(const SampledSpectrum& spectrum);

/// The colour with each channel clamped to [0, 1], with a remark that begins with `what`.
Rgb clamped_reflectance(LoadState& context, const FilePosition& place, const std::string& what,
                        const Rgb& rgb);

/// The colour for a message.
std::string text(const Rgb& c);

}  // namespace lucerna::pbrt

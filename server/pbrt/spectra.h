// Spectra as linear RGB: the server's lights are RGB until scenes are rendered with wavelengths.
#pragma once

#include <span>

#include "lights/rgb.h"
#include "server/pbrt/params.h"

namespace lucerna::pbrt {

/// A light's colour in linear RGB, luminance 1, no channel negative.
struct LightColour {
  Rgb<double> rgb;
  bool clipped = false;  ///< outside of the RGB gamut: negative channels were set to 0
};

/// CIE 1931 colour matching functions (x, y, z) at a wavelength [nm], by the sums of lobes of
/// [Wyman13]; within 0.03 of the tables, whose largest value is 1.78.
Vec3<double> colour_matching(double wavelength_nm);

/// A black body of `kelvin` > 0, over 360 to 830 nm.  Chromaticities come out within 0.003 of the
/// tabulated Planckian locus between 2000 and 10000 K.
LightColour blackbody_colour(double kelvin);

/// A spectrum linear between its samples and 0 beyond them; wavelengths [nm] ascend.  Black where
/// the eye sees nothing of it.
LightColour spectrum_colour(std::span<const double> wavelengths_nm, std::span<const double> values);

/// The level that a light's parameter `name` gives, before `scale`: the channels of an rgb as they
/// are, spectra and black bodies at luminance 1, white of luminance 1 where it is not given.
/// Fails on negative values.
Rgb<double> light_level(Context& context, const ParameterSet& params, std::string_view name);

/// What a reflectance parameter (rgb, spectrum, float) says, each channel clamped to [0, 1].
/// Textures are the caller's.
Rgb<double> reflectance(Context& context, const Parameter& parameter);

}  // namespace lucerna::pbrt

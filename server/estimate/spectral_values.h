// Spectral values of lights from their RGB values.
//
// At each wavelength, a light with a spectrum has the luminance of its value times the spectrum per
// lumen.  A light with RGB values has a smooth spectrum of the same colour (rgb_basis_per_lumen).
// Both are linear, so they apply to sums of values, to fluxes and to irradiances.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "server/scene/scene.h"

namespace lucerna {

/// Keeps a few hundred spectra after their first use.  Not thread-safe: each chunk of work has
/// its own object.
class SpectralValues {
 public:
  /// `scene` and `wavelengths_nm` must outlive it.
  SpectralValues(const Scene& scene, std::span<const double> wavelengths_nm)
      : scene_(scene), wavelengths_nm_(wavelengths_nm) {}

  /// The number of wavelengths.
  std::size_t size() const { return wavelengths_nm_.size(); }

  /// Adds to sum[k] the spectral value of `value` of light `light` at wavelength k [unit of
  /// value / lm W / nm].
  void add(std::uint32_t light, const Rgb& value, std::span<double> sum) {
    add(scene_.lights().spectrum_number(light), value, sum);
  }
  /// The same for a spectrum of the scene by its number; unset: for lights with RGB values.
  void add(std::optional<std::uint32_t> spectrum, const Rgb& value, std::span<double> sum);

 private:
  const Scene& scene_;
  std::span<const double> wavelengths_nm_;
  std::vector<Rgb> basis_;                                            // empty until it is needed
  std::unordered_map<std::uint32_t, std::vector<double>> per_lumen_;  // by number of the spectrum
};

/// Writes the values as floats.  Returns false, with nothing written, if one does not fit a float.
bool store_spectral(std::span<const double> values, float* out);

}  // namespace lucerna

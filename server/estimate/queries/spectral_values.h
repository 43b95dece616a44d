// Light wavelength by wavelength: what the RGB values of lights stand for.
//
// A light that was given a spectrum has at each wavelength the luminance of its value times the
// spectrum per lumen; one that was given RGB, a smooth spectrum that looks like its value
// (rgb_basis_per_lumen).  Both are linear: what holds for values holds for sums of them, for
// fluxes and for irradiances.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "server/scene/scene.h"

namespace lucerna {

/// Spectra are looked up at their first light and kept for the next, a few hundred at a time.  Not
/// thread-safe: each chunk of work has its own.
class SpectralValues {
 public:
  /// `scene` and `wavelengths_nm` must outlive it.
  SpectralValues(const Scene& scene, std::span<const double> wavelengths_nm)
      : scene_(scene), wavelengths_nm_(wavelengths_nm) {}

  /// Of how many wavelengths.
  std::size_t size() const { return wavelengths_nm_.size(); }

  /// Adds to sum[k] what `value` of light `light` is at wavelength k [unit of value / lm W / nm].
  void add(std::uint32_t light, const Rgb<double>& value, std::span<double> sum) {
    add(scene_.spectrum_number(light), value, sum);
  }
  /// The same of the scene's spectrum of that number; none: of lights that were given RGB.
  void add(std::optional<std::uint32_t> spectrum, const Rgb<double>& value, std::span<double> sum);

 private:
  const Scene& scene_;
  std::span<const double> wavelengths_nm_;
  std::vector<Rgb<double>> basis_;                                    // empty until it is needed
  std::unordered_map<std::uint32_t, std::vector<double>> per_lumen_;  // by number of the spectrum
};

/// Writes the values as floats; false, and nothing is written, where one does not fit a float.
bool store_spectral(std::span<const double> values, float* out);

}  // namespace lucerna

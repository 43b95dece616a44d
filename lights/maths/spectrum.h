// Spectra of lights, and the light of a given RGB at each wavelength.
//
// Lights compute in RGB. A spectrum distributes a light's luminance over wavelengths.  A light
// value of luminance Y has the spectral value Y s(nm), where s is the spectrum per lumen.
//
// Integrals use the CIE 1931 observer, whose tables have an entry every 5 nm.  For smooth spectra
// and the CIE's illuminants the integral is the sum over the table's wavelengths, times 5 nm
// [CIE15].  Samples may be finer than the table.  Their product with the observer is integrated
// exactly, with both factors linear between entries.  The observer is 0 outside 360 to 830 nm.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"

namespace lucerna {

struct BlackBody {
  double kelvin;
};

/// Linear between samples, 0 outside.
struct SampledSpectrum {
  std::vector<double> wavelengths_nm;
  std::vector<double> values;
};

/// Errors: lengths that differ or are 0; wavelengths that are negative, infinite or do not ascend;
/// values that are negative or infinite.
absl::Status check_samples(const SampledSpectrum& samples);

struct CieIlluminant {
  std::string name;  ///< "A", "D65", "F2"
};

/// The limit for all spectra.  Its product with the flux of a light in floats fits a double.  (A
/// black body of 100 K, the darkest allowed, has 4e72.)
inline constexpr double kMostWattsPerLumen = 1e100;

/// Immutable.  Only the `create` functions can fail.
class Spectrum {
 public:
  using Source = std::variant<BlackBody, CieIlluminant, SampledSpectrum>;

  /// Errors: a temperature outside of [100, 1e7] K.
  static absl::StatusOr<Spectrum> create(const BlackBody& source);
  /// Errors: a name without a table in colord-data.
  static absl::StatusOr<Spectrum> create(const CieIlluminant& source);
  /// Errors: those of check_samples; FAILED_PRECONDITION for invisible spectra, with less than 1 /
  /// kMostWattsPerLumen [lm/W].
  static absl::StatusOr<Spectrum> create(SampledSpectrum source);

  const Source& source() const { return source_; }
  /// s(nm) [W/nm per lm]: 683 lm/W times the integral of s y is 1.  Finite.
  double per_lumen(double nm) const;
  /// Radiant flux per luminous flux over the whole spectrum; for a black body over all wavelengths
  /// [W per lm].
  double watts_per_lumen() const { return watts_per_lumen_; }
  /// Its colour at luminance 1, no channel negative.
  const Rgb& rgb() const { return rgb_; }
  /// True if the colour is outside of RGB: negative channels were set to 0.
  bool clipped() const { return clipped_; }
  /// Memory, with the object itself.
  std::uint64_t bytes() const;

 private:
  Spectrum(Source source, const Vec3& xyz);

  Source source_;
  double log_per_lumen_ = 0;  // of black bodies: ln s(nm) - log_planck(nm)
  double largest_ = 1;        // of samples
  double scale_ = 1;          // of the others: W/nm per lm for each unit of value / largest
  double watts_per_lumen_ = 0;
  Rgb rgb_;
  bool clipped_ = false;
};

/// X, Y and Z of samples: the integral against the observer [nm times the unit of the values].  The
/// samples are linear between wavelengths and 0 outside; wavelengths ascend.
Vec3 tristimulus(std::span<const double> wavelengths_nm, std::span<const double> values);

/// Linear RGB of a colour in XYZ, with the primaries of Rec. 709 and the white of the D65 table.
/// Its chromaticity (0.31271, 0.32901) differs from that of Rec. 709 in the fifth digit.  So X and
/// Z are scaled first, by less than 3e-4, and D65 is (1, 1, 1).  [BT709]
Rgb rgb_from_xyz(const Vec3& xyz);

/// Linear RGB of a surface under D65, from samples of its reflectance: linear between wavelengths
/// and 0 outside; wavelengths ascend.  The product with D65 times the observer is integrated
/// exactly, with both factors linear between entries.  A reflectance of c from 360 to 830 nm gives
/// (c, c, c) to rounding.  Saturated colours have channels below 0 or above 1.  [CIE15]
Rgb reflected_rgb(std::span<const double> wavelengths_nm, std::span<const double> values);

/// For RGB lights: the light of RGB c has at `nm` the spectral value c.r b.r + c.g b.g + c.b b.b
/// [W/nm per lm].  The three spectra are smooth: D65 times reflectances that add up to 1.  White is
/// D65, and the sum over the observer's table gives c to 1e-9.  [Mallett19]
Rgb rgb_basis_per_lumen(double nm);

}  // namespace lucerna

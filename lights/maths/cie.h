// The tables of the CIE from Debian's colord-data.  The build turns them into C++.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "lights/maths/vec.h"

namespace lucerna::cie {

/// The luminous efficacy of monochromatic light of 540 THz (555 nm) [lm/W].  It defines the lumen.
inline constexpr double kLumensPerWatt = 683;

inline constexpr double kObserverFirstNm = 360;
inline constexpr double kObserverStepNm = 5;
inline constexpr std::size_t kObserverSize = 95;

/// Colour matching functions of the 1931 standard observer (2 degrees), entry k at 360 + 5 k nm,
/// to 830 nm.  [CIE15]
std::span<const Vec3, kObserverSize> observer();

/// Relative spectral power of an illuminant, equally spaced.  [CIE15]
struct Illuminant {
  std::string_view name;  ///< "A", "D65", "F2"
  double first_nm;
  double step_nm;
  std::span<const double> values;
};
std::span<const Illuminant> illuminants();

/// The illuminant of this name; null if it is not in `illuminants()`.
const Illuminant* find_illuminant(std::string_view name);

/// Relative spectral power at `nm`, linear between entries, 0 outside.
double value_at(const Illuminant& illuminant, double nm);

}  // namespace lucerna::cie

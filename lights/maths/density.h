// Probability densities with their measure in the type, and the conversion between them.
#pragma once

#include <cmath>
#include <concepts>

namespace lucerna {

/// Density with respect to solid angle at the receiver [1/sr].
struct SolidAnglePdf {
  double per_sr{};
  bool operator==(const SolidAnglePdf&) const = default;
};

/// Density with respect to area on the light [1/m2].
struct AreaPdf {
  double per_m2{};
  bool operator==(const AreaPdf&) const = default;
};

/// The solid angle that an area A at `distance` [m] subtends is A cos / distance^2.  `cos_light` is
/// the absolute cosine between the light's normal and the direction to the receiver.  So p_sr =
/// p_area distance^2 / cos.  Infinite where `cos_light` is 0.  [Pharr23, 4.2.3]
inline SolidAnglePdf to_solid_angle(AreaPdf pdf, double distance, double cos_light) {
  // One multiplication by distance at a time, because distance^2 alone overflows or underflows
  // first.
  return {pdf.per_m2 * distance / cos_light * distance};
}

}  // namespace lucerna

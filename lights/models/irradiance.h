// Irradiance in closed form, for the lights that have one.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "lights/sampling/light_sample.h"

namespace lucerna {

/// Lights whose irradiance may have a closed form.  `irradiance(receiver)` is the irradiance
/// without occlusion on the side that the receiver faces [lx], or nothing if there is no such form.
/// A surface, or the light itself (`hides_itself`), may block a part of it.
template <typename L>
concept HasIrradiance = requires(const L& light, const Receiver& receiver) {
  light.irradiance(receiver);
  light.hides_itself();
};

/// Upper bounds of the illuminance at a receiver, or of the spherical illuminance if it has no
/// normal.  `lx` is 0 only where certainly no light arrives.
struct MostIrradiance {
  double lx = 0;
  /// Of one sample of `sample_li`: its value times the cosine, divided by the density.  Infinite if
  /// no bound is known.
  double sample_lx = 0;
};

/// The bounds of a light at infinity that has `irradiance`.
template <typename L>
MostIrradiance most_from_beyond(const L& light, const Receiver& receiver) {
  // A disk of radius 1 that faces every direction receives pi times the integral of the radiance.
  const double all = luminance(light.power({{}, 1}).lumens) / std::numbers::pi;
  const auto lx = light.irradiance(receiver);
  return {lx ? luminance(Rgb(*lx)) : all, all};
}

/// The irradiance [lx] from `radiance` [cd/m2] in all directions of a projected solid angle.
/// `projected_sr` returns that angle for the receiver's unit normal, or nothing.  The irradiance is
/// proportional to the length of the receiver's normal, as the cosines of samples are.
template <typename F>
std::optional<Rgb> irradiance_of(const Rgb& radiance, const Receiver& receiver,
                                 const F& projected_sr) {
  const Vec3 n(receiver.normal);
  const double magnitude = length(n);
  if (!is_finite(receiver.position) || !(magnitude > 0) || !std::isfinite(magnitude))
    return std::nullopt;
  const std::optional<double> sr = projected_sr(n / magnitude);
  if (!sr) return std::nullopt;
  const Rgb lx(radiance * (*sr * magnitude));
  return is_finite(lx) ? std::optional(lx) : std::nullopt;
}

}  // namespace lucerna

// Irradiance in closed form, for the lights that have one.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "lights/models/light.h"

namespace lucerna {

/// The bounds of a light at infinity that has `irradiance`.
inline MostIrradiance most_from_beyond(const Light& light, const Receiver& receiver) {
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

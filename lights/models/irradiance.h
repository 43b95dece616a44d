// Irradiance in closed form: what the lights that have one share.
#pragma once

#include <cmath>
#include <optional>

#include "lights/sampling/light_sample.h"

namespace lucerna {

/// Lights whose irradiance may have a closed form: `irradiance(receiver)` is that on the side that
/// the receiver faces with nothing in the way [lx], or nothing where there is no such form.  It is
/// all that arrives unless something, or the light itself (`hides_itself`), stands between.
template <typename L>
concept HasIrradiance = requires(const L& light, const Receiver<double>& receiver) {
  light.irradiance(receiver);
  light.hides_itself();
};

/// What `radiance` [cd/m2] from all directions of a projected solid angle comes to [lx];
/// `projected_sr` says how large that is for the receiver's unit normal, or nothing.  As samples'
/// cosines, the irradiance is in proportion to the length of the receiver's normal.
template <std::floating_point Real, typename F>
std::optional<Rgb<Real>> irradiance_of(const Rgb<double>& radiance, const Receiver<Real>& receiver,
                                       const F& projected_sr) {
  const Vec3<double> n(receiver.normal);
  const double magnitude = length(n);
  if (!is_finite(receiver.position) || !(magnitude > 0) || !std::isfinite(magnitude))
    return std::nullopt;
  const std::optional<double> sr = projected_sr(n / magnitude);
  if (!sr) return std::nullopt;
  const Rgb<Real> lx(radiance * (*sr * magnitude));
  return is_finite(lx) ? std::optional(lx) : std::nullopt;
}

}  // namespace lucerna

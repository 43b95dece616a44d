// Reflection and refraction at the boundary of two media.
#pragma once

#include <optional>

#include "lights/maths/rgb.h"
#include "lights/maths/vec.h"

namespace lucerna {

/// The share of unpolarised light that a boundary between two dielectrics reflects.  `cos_i` is the
/// cosine of the angle to the normal on the side of `eta_i`; negative on the other side.  `eta`:
/// the index beyond the boundary over that of the side to which the normal points, above 0.  1 for
/// total internal reflection.  [Born99, 1.5.2]
double fresnel_dielectric(double cos_i, double eta);

/// The same for a conductor with the complex index eta + i k, relative to the outside.  Each
/// channel has its own index.  `cos_i` in [0, 1], eta >= 0, k >= 0.  [Born99, 14.2]
Rgb fresnel_conductor(double cos_i, const Rgb& eta, const Rgb& k);

/// Light that arrives from `w` and passes a boundary with the unit normal `n`.
struct Refracted {
  Vec3 w;      ///< unit, away from the surface on the other side
  double eta;  ///< index on the side of `w` over that on the other side
};
/// Nothing for total internal reflection.  `eta`: the index on the side to which -n points, over
/// that to which n points.  [Pharr23, 9.3.2]
std::optional<Refracted> refract(const Vec3& w, Vec3 n, double eta);

}  // namespace lucerna

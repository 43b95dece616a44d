// Helpers for cases of area lights in the contract suites.
#pragma once

#include <cmath>
#include <optional>

#include "tests/lights/contract/area_helpers.h"
#include "tests/lights/contract/contract.h"

namespace lucerna::testing {

inline constexpr Rgb kLevel{1, 2, 4};

struct AreaCase : CaseDefaults {
  /// All of the light seen from `receiver`: it lies within kSize of the origin.
  static Region region(const Vec3& receiver) {
    return {normalized(-receiver), 1.05 * std::asin(1.5 / length(receiver))};
  }
  static Rgb emitted(const Vec3&, const Vec3&) { return kLevel; }
  static constexpr bool kConfined = true;
};

/// The hemisphere about `n`.
inline Region hemisphere(const Vec3& n) { return {normalized(n), kPi / 2}; }

/// The angle of `p` about z, as a share of `whole`.
inline double share_of_turn(const Vec3& p, double whole) {
  const double phi = std::atan2(p.y, p.x);
  return (phi < -1e-6 ? phi + 2 * kPi : phi) / whole;
}

/// pi L A: the cosine-weighted integral over the hemisphere, times the area.
inline Rgb lambertian_power(double area) {
  return integrate(Region{{0, 0, 1}, kPi / 2}, 1000,
                   [&](const Vec3& w) { return kLevel * (area * w.z); });
}

/// Where the ray from `r` along `wi` meets the plane z = 0 from above, if it does.
inline std::optional<Vec3> from_above(const Vec3& r, const Vec3& wi) {
  if (!(r.z > 0 && wi.z < 0)) return std::nullopt;
  return r - wi * (r.z / wi.z);
}

/// Whether the light of a case has a closed form at its first receiver.
template <typename Case>
bool has_irradiance() {
  Receiver receiver(Case::receivers().front());
  receiver.normal = {0, 0, 1};
  return Case::make({}).irradiance(receiver).has_value();
}

}  // namespace lucerna::testing

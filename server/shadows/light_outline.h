// What of a light a receiver must have in view, so that all of its light arrives.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

struct SceneLight;

/// Of what is round, and at most.
inline constexpr int kOutlineCorners = 12;

/// About the scene's origin [m].
struct LightOutline {
  enum class Kind : std::uint8_t {
    kNone,    ///< not known, or nothing that stays where it is
    kFlat,    ///< a part of a plane, within the convex polygon of `corners`
    kSphere,  ///< seen from outside; `center`, `radius`
    kSun,     ///< all directions within `half_angle_rad` of `axis`
    kPortal,  ///< all directions through the polygon of `corners`, on the other side of `axis`
    kSky,     ///< all directions
  };

  Kind kind = Kind::kNone;
  std::vector<Vec3<double>> corners{};
  Vec3<double> axis{};  ///< unit; of the flat and the portal their normal
  Vec3<double> center{};
  double radius = 0, half_angle_rad = 0;
};

/// Of lights that rest, whose irradiance has a closed form (lights/models/irradiance.h) and that
/// hide no part of themselves.
LightOutline outline_of(const SceneLight& light);

/// A regular polygon around the circle or ellipse whose half-axes from `center` are `x` and `y`.
std::array<Vec3<double>, kOutlineCorners> polygon_around(const Vec3<double>& center,
                                                         const Vec3<double>& x,
                                                         const Vec3<double>& y);

}  // namespace lucerna

// The part of a light that a receiver must see, so that all of its light arrives.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lights/maths/vec.h"

namespace lucerna {

struct SceneLight;

/// Corners of the polygon around round outlines, and the largest number of corners.
inline constexpr int kOutlineCorners = 12;

/// About the scene's origin [m].
struct LightOutline {
  enum class Kind : std::uint8_t {
    kNone,    ///< unknown, or a light that moves
    kFlat,    ///< part of a plane, within the convex polygon of `corners`
    kSphere,  ///< seen from outside; `center`, `radius`
    kSun,     ///< all directions within `half_angle_rad` of `axis`
    kPortal,  ///< all directions through the polygon of `corners`, on the other side of `axis`
    kSky,     ///< all directions
  };

  Kind kind = Kind::kNone;
  std::vector<Vec3> corners{};
  Vec3 axis{};  ///< unit; the normal of kFlat and kPortal
  Vec3 center{};
  double radius = 0, half_angle_rad = 0;
};

/// The outline of a light that does not move, has irradiance in closed form
/// (lights/models/irradiance.h) and does not hide parts of itself; otherwise kNone.
LightOutline outline_of(const SceneLight& light);

/// A regular polygon around a circle or an ellipse with centre `center` and half-axes `x` and
/// `y`.
std::array<Vec3, kOutlineCorners> polygon_around(const Vec3& center, const Vec3& x, const Vec3& y);

}  // namespace lucerna

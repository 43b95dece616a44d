// The data that a bounding hierarchy of lights stores for each light: a box and a cone of
// directions.  They bound the light that a receiver may get.
#pragma once

#include "lights/sampling/light_sample.h"

namespace lucerna {

/// Bounds that contain all of a light.  Every point that emits lies in the box, and every direction
/// of emission lies within `cone_rad` of `axis`. They may be slightly too large, never too small.
/// [Conty18]
struct LightBounds {
  Vec3 lower, upper;   ///< about the scene's origin [m]
  Vec3 axis{0, 0, 1};  ///< unit
  /// Half angle of the cone, in [0, pi]: the angle of the normals plus the angle of emission about
  /// a normal.
  double cone_rad{};
  /// Half angle of the cone of the normals (theta_o), in [cone_rad - pi / 2, cone_rad]. Outside of
  /// it, intensity falls off with the cosine of the angle to the nearest normal.  It equals
  /// `cone_rad` where no cosine is known, as for all lights without a surface.
  double normals_rad = cone_rad;
  /// Both sides emit: normals lie within `normals_rad` of `axis` or of its opposite, and `cone_rad`
  /// is pi.
  bool two_sided = false;

  /// False only where no light arrives at `position`, because no ray from the box to it lies in the
  /// cone.
  bool reaches(const Vec3& position) const;
};

}  // namespace lucerna

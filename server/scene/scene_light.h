// One light of a scene.
#pragma once

#include <cstdint>
#include <memory>

#include "lights/maths/motion.h"
#include "lights/models/light.h"

namespace lucerna {

using LightPointer = std::shared_ptr<const Light>;

/// The motion of a light.
struct LightMotion {
  Motion motion;  ///< from its own coordinates at its first key frame to the scene's
  Vec3 origin_m;  ///< world position of the zero of its own coordinates
  /// Largest coordinate of the light's surface about its own zero [m].  Rays find the surface only
  /// to the rounding of floats of this size.  0 for lights without a surface.
  float reach_m = 0;
  /// The motion in the world, as the scene file gives it.
  std::shared_ptr<const Motion> world{};
  /// Set for lights with a direction and no place.  They use the rotations of `motion` but not the
  /// shifts, whose length depends on the distance from the centre of rotation.
  bool only_turns = false;

  Pose at(double time_s) const {
    Pose pose = motion.at(time_s);
    if (only_turns) pose.shift_m = {};
    return pose;
  }
};

/// One light of the scene.
struct SceneLight {
  std::uint64_t id;    ///< stable: from 1 for lights of the file, from 2^32 for added ones
  LightPointer light;  ///< about the scene's origin; about its own if it moves
  std::shared_ptr<const LightMotion> moving;  ///< null if it does not move
  std::uint32_t samples = 1;  ///< points of each sample on it; the default of queries
  bool is_unseen = false;     ///< as in ShapeDescription::Emission
  // Place of the light in the scene files, as in SourceLocation; the file is an index into the
  // scene's files.
  std::uint32_t file = 0;
  int line = 0, column = 0;

  /// LightMotion::reach_m.
  float reach_m() const { return moving != nullptr ? moving->reach_m : 0; }
};

}  // namespace lucerna

// Questions about a random scene.
#pragma once

#include <string>
#include <vector>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

struct Question {
  enum class Kind : std::uint8_t {
    kVisibility,
    kIlluminance,
    kTarget,  ///< illuminance with a target error
    kSolid,   ///< a receiver inside of a sphere
    kPower,
    kRays,   ///< that leave a light
    kDelta,  ///< the sample of a light of one direction
    kSamples,
    kDensity,
    kLe
  };
  Kind kind = Kind::kVisibility;
  Place from{}, to{};  ///< visibility: both ends; else the receiver, except for power
  /// Of power, rays, delta, samples, density and le: first World::lights, then the shapes that
  /// emit.
  int source = -1;
};

std::vector<Question> questions_about(const World& world);
std::string name_of(Question::Kind kind);

}  // namespace lucerna::oracle

// Chooses a light for a sample with a probability by luminous power.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lights/maths/vec.h"
#include "lights/models/light_tree.h"

namespace lucerna {

/// A number in [0, 1) that chooses a light, from the 48 bits of a pair.  24 bits would leave
/// some of more than 2^24 lights without a sample.
inline double choosing_value(const Vec2f& u) { return double{u.x} + double{u.y} * 0x1p-24; }

/// The discrete distribution over n lights.  Nine tenths are proportional to power, and one tenth
/// is equal for all lights with power above 0.  The equal part is needed because a weak light may
/// be the only one that a receiver sees.  Also, the flux of distant and infinite lights depends on
/// the size of the scene.  A light of power 0 is never chosen.  If all lights are black, all are
/// equally likely.
class LightDistribution {
 public:
  LightDistribution() = default;
  /// `lumens`: one power for each light, finite, not negative.
  explicit LightDistribution(std::span<const double> lumens);

  bool empty() const { return cumulative_.empty(); }
  /// `u` in [0, 1).
  LightChoice choose(double u) const;
  double probability(std::uint32_t light) const {
    return cumulative_[light] - (light > 0 ? cumulative_[light - 1] : 0);
  }
  std::size_t bytes() const { return cumulative_.capacity() * sizeof(double); }

 private:
  std::vector<double> cumulative_;  // the last one is exactly 1
};

}  // namespace lucerna

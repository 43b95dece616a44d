// The data that a light tree stores for several lights together: their place, their directions and
// their power.
#pragma once

#include <limits>

#include "lights/maths/vec.h"

namespace lucerna {

/// The bounds of all lights that were added: a box, a cone of normals, and whether light outside
/// the cone falls off by the cosine.  `has_cosine` replaces the paper's theta_e, which is pi / 2 on
/// surfaces and absent elsewhere.  [Conty18, 4]
struct LightCluster {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  Vec3 lower{kInfinity, kInfinity, kInfinity};
  Vec3 upper{-kInfinity, -kInfinity, -kInfinity};
  Vec3 axis{0, 0, 1};       ///< unit
  double theta_o_rad = -1;  ///< half angle of the cone; negative: no light yet; pi: all directions
  bool has_cosine = false;  ///< intensity falls off outside of theta_o, and is not 0 there
  bool two_sided = false;   ///< normals lie about `axis` or about its opposite
  double power = 0;         ///< the sum over all lights, in any unit

  bool empty() const { return theta_o_rad < 0; }
  void add(const LightCluster& other);

  /// The integral over all directions of the cosine to the nearest normal, 1 within the cone [sr].
  /// Power divided by this is the intensity towards the middle.  [Conty18, equation 1]
  double solid_angle_sr() const;
  /// The quantity that a split minimises: power times the squared diagonal times solid_angle_sr().
  /// The paper uses the box's area, which is 0 for lights in a line.
  double cost() const;

 private:
  void add_cone(const LightCluster& other);
};

}  // namespace lucerna

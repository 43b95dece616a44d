// What a light tree knows of several lights together: where they are, which way they shine, and how
// much.
#pragma once

#include <limits>

#include "lights/maths/vec.h"

namespace lucerna {

/// The bounds of no light, of one, or of those that were added: a box, a cone of normals and
/// whether light falls off beyond it by the cosine, which is all of the paper's theta_e that lights
/// have: pi / 2 on surfaces, none elsewhere.  [Conty18, 4]
struct LightCluster {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  Vec3<double> lower{kInfinity, kInfinity, kInfinity};
  Vec3<double> upper{-kInfinity, -kInfinity, -kInfinity};
  Vec3<double> axis{0, 0, 1};  ///< unit
  double theta_o_rad = -1;     ///< negative: of no light; pi: all directions
  bool has_cosine = false;     ///< intensity falls off beyond theta_o, and is not 0 there
  bool two_sided = false;      ///< normals lie about `axis` or about its opposite
  double power = 0;            ///< the sum of all, in any unit

  bool empty() const { return theta_o_rad < 0; }
  void add(const LightCluster& other);

  /// The integral over all directions of the cosine to the nearest normal, 1 within the cone [sr]:
  /// power over this is the intensity towards the middle.  [Conty18, equation 1]
  double solid_angle_sr() const;
  /// What a split is to make small: power times the square of the diagonal times solid_angle_sr().
  /// The paper has the box's area, which is 0 for lights in a line however long it is.
  double cost() const;

 private:
  void add_cone(const LightCluster& other);
};

}  // namespace lucerna

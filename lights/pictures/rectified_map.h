// The picture that a portal shows, in coordinates in which every view of the portal is a rectangle.
#pragma once

#include <cstddef>
#include <vector>

#include "lights/pictures/map_illuminance.h"
#include "lights/pictures/sphere_map.h"

namespace lucerna {

/// Directions w with w.z > 0 in a portal's axes, as points of the unit square: (alpha, beta) / pi +
/// 1/2, where w is along (tan alpha, tan beta, 1).  [Bitterli15]
Vec2 square_from_rectified(const Vec3& w);
/// The unit vector of a point, which is clamped to the square.
Vec3 rectified_from_square(Vec2 p);
/// Solid angle per area of the square at the unit vector w.
double sr_per_square(const Vec3& w);

/// The illuminance of each of n x n cells of the square on the portal.
class RectifiedCells {
 public:
  explicit RectifiedCells(int n);
  /// The cells of row j under radiance 1 [lx], each with a relative error below 1e-13.  This holds
  /// along the edges too, where values are smallest.
  std::vector<double> row(int j) const;

 private:
  static constexpr std::size_t kNodes = 5;
  int n_;
  std::vector<double> squared_sine_;  ///< at the nodes of the first half of cells along a side
};

/// A map seen through a portal as in pbrt-v4: n x n cells of the square, where n is the number of
/// rows of the map.  Each cell has the bilinear filter's value towards its middle.  Immutable.
class RectifiedMap {
 public:
  /// `x`, `y`, `z`: the portal's axes in the map's axes.
  RectifiedMap(const SphereMap& map, const Vec3& x, const Vec3& y, const Vec3& z);

  Rgb lookup(Vec2 p) const;
  /// The illuminance on the portal, summed over RectifiedCells, exact to rounding.
  /// `without_cosine` is computed as in pbrt-v4, from the middles of cells.
  MapIlluminance illuminance(const Rgb& radiance) const;
  std::size_t bytes() const { return sizeof(*this) + texels_.capacity() * sizeof texels_[0]; }

 private:
  int n_;
  std::vector<Rgb> texels_;
};

}  // namespace lucerna

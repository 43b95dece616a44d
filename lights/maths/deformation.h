// Directions under a linear map that scales unequally or shears.
#pragma once

#include <absl/status/statusor.h>

#include "lights/maths/emission_cone.h"
#include "lights/maths/transform.h"

namespace lucerna {

/// Maps directions between a light's own space, where its angles are measured, and the world.
/// Immutable.
class Deformation {
 public:
  /// `axes`: the world vectors of x, y and z of the light's own space.  Errors: vectors that are
  /// not finite or that lie in a plane.
  static absl::StatusOr<Deformation> create(const Frame& axes);

  /// Of any length but 0; the result has any length.
  Vec3 own_from_world(const Vec3& w) const { return inverse_.vector(w); }
  Frame own_from_world(const Frame& axes) const {
    return {own_from_world(axes.s), own_from_world(axes.t), own_from_world(axes.n)};
  }
  Vec3 world_from_own(const Vec3& w) const { return map_.vector(w); }
  /// Solid angle in the light's own space for one in the world around the unit vector `w`.
  double own_sr_per_world_sr(const Vec3& w) const;
  /// A bound of the solid angle in the world for one in the light's own space.
  double most_world_sr_per_own_sr() const { return most_shrinking_; }
  /// A cone that holds all directions of a cone of the light's own space.
  EmissionCone world_cone(const EmissionCone& own) const;

 private:
  explicit Deformation(const Transform& map);

  Transform map_, inverse_;
  double determinant_;  ///< of the inverse, positive
  double most_shrinking_;
  double stretch_;  ///< a bound on the ratio of the largest to the smallest scale
};

}  // namespace lucerna

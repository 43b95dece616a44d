// What the oracle knows of single shapes.
#pragma once

#include <vector>

#include "tests/oracle/world.h"

namespace lucerna::oracle {

inline bool is_curved(const Shape& shape) {
  return shape.kind == ShapeKind::kPatch || shape.kind == ShapeKind::kCylinder;
}
inline bool is_flat(const Shape& shape) {
  return !is_curved(shape) && shape.kind != ShapeKind::kSphere;
}

/// Points whose convex hull holds the shape, or the corners of a box around it.
std::vector<Vec> hull(const Shape& shape);
/// Of a flat shape, unit, on the side that emits.
Vec normal_of(const Shape& shape);
/// The corners of a polygon around the flat shape, in order.
std::vector<Vec> surroundings(const Shape& shape);
/// How far inside of the flat shape's border a point of its plane lies; negative outside, where it
/// is at most the distance.  `n`: normal_of(shape).
Real inside_by(const Shape& shape, const Vec& n, const Vec& p);

/// A point of a shape with its unit normal, on the side that emits.
struct SurfacePoint {
  Vec at, normal;
};
/// `s` and `t` are in [0, 1].  Over triangles, parallelograms, disks, spheres and cylinders they
/// are uniform by area.
SurfacePoint point_of(const Shape& shape, Real s, Real t);
/// The point of a flat shape, a sphere or a cylinder nearest to `p`, which may be outside of its
/// border.
SurfacePoint nearest_point(const Shape& shape, const Vec& p);
/// The least extent along the surface [m].
Real shape_size(const Shape& shape);
/// [m2], with a bound of its error.
std::pair<Real, Real> area_of(const Shape& shape);

}  // namespace lucerna::oracle

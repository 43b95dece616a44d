// Curves that rays meet in double precision.
//
// Embree has curves of its own, but not these: its flat curves are chains of four quadrilaterals,
// and its round ones have normals and errors of floats.  Curves of pbrt-v4 meet a ray where it
// passes the curve's axis within half the width.  [Pharr16, 3.7]
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "lights/maths/vec.h"
#include "lights/shapes/shape.h"
#include "server/description/curve_pieces.h"

namespace lucerna {

/// A part of a curve.  Its ends are open.
///
/// - Flat: a ribbon that faces every ray.  A ray hits it if it passes within the radius of the
/// axis,
///   at its nearest point.
/// - Cylinder: the same, but its normal turns with the distance from the axis, up to a right angle.
///   As in pbrt-v4, it turns inwards: the curve looks like the inside of half a pipe.
/// - Ribbon: a strip across the axis and the normal, which turns evenly between its ends.
struct CurvePiece {
  std::array<Vec3, 4> points;  ///< of a cubic Bezier curve [m]
  double start_radius_m = 0, end_radius_m = 0;
  std::array<Vec3f, 2> normals{};  ///< of a ribbon: unit, at both ends
  CurveKind kind = CurveKind::kFlat;

  Vec3 at(double u) const;
  Vec3 derivative(double u) const;
  double radius_m(double u) const { return start_radius_m + (end_radius_m - start_radius_m) * u; }

  /// Nearest hit in (t_min, t_max).  Its normal faces the ray.  For a ribbon it follows the
  /// ribbon's own normals.  u along the piece and v across it, both in [0, 1], go to
  /// `*uv_hit` if that is not null.
  std::optional<ShapeHit> intersect(const Vec3& origin, const Vec3& direction, double t_min,
                                    double t_max, Vec2* uv_hit = nullptr) const;
  /// {lower, upper}
  std::pair<Vec3, Vec3> bounds() const;

  /// How far from a hit other rays may find the surface, without roundings [m].  A curve that turns
  /// with each ray is found within its radius of the axis.  So rays that leave a flat curve or a
  /// ribbon do not hit it again.  Some rays that leave a cylinder meet its other side, because its
  /// normal leans inwards (docs/decisions/037-curves.md).
  double hit_error_m(double u) const;
};

/// The pieces of a curve, about `origin`.  Long curves have four, so that boxes around them are
/// small.
std::vector<CurvePiece> pieces_of(const CubicCurve& curve, CurveKind kind, const Vec3& origin);

}  // namespace lucerna

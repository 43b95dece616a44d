// Cubic Bezier curves from the control points of Bezier curves or a B-spline.
#pragma once

#include <absl/status/status.h>

#include <array>
#include <cstddef>

#include "server/description/scene_description.h"

namespace lucerna {

/// A cubic Bezier curve.  Its width changes evenly.
struct CubicCurve {
  std::array<Vec3, 4> points;
  double start_width_m = 0, end_width_m = 0;  ///< at least 0
  std::array<Vec3, 2> normals{};              ///< of a ribbon: unit, at its start and its end
};

/// The most curves of one CurveData.
inline constexpr std::size_t kMostCurves = std::size_t{1} << 20;

/// Errors (INVALID_ARGUMENT): too few points, a number of points that does not end a Bezier curve,
/// a wrong number of normals.  RESOURCE_EXHAUSTED above kMostCurves.
absl::Status check_curves(const CurveData& curves);

/// Curve `i` < curves.count().  Requires check_curves(curves).
CubicCurve cubic_curve(const CurveData& curves, std::size_t i);

}  // namespace lucerna
